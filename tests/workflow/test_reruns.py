"""What runs again after a change, by the counts of a dry run on a finished campaign."""

import shutil

import pytest

CASES = """case\tmicrostructure\tcrack\tincrements\tgrowth\tsizing.l_min
notch\tsynthetic\ttiny\t3\tprescribed\t
grown\tsynthetic\ttiny\t2\tgrow\t
"""
# stages of an increment from sizes to the deck, by their jobs
STAGES = {"size": 1, "stitch": 1, "gradate": 1, "tetrahedralize": 2, "assemble": 1, "inp": 1, "check": 1}
LAST = {"report": 1, "all": 1}


def times(count: int, jobs: dict[str, int]) -> dict[str, int]:
    return {rule: count * number for rule, number in jobs.items()}


@pytest.fixture(scope="module")
def original(new_folder, idle_python):
    """A finished campaign of two cases, whose files hold no meshes."""
    folder = new_folder(CASES, python=idle_python)
    run = folder.snakemake("--cores", "2")
    assert run.status == 0, run.text
    return folder


@pytest.fixture
def finished(original, tmp_path):
    """A copy of it to be changed."""
    return type(original)(shutil.copytree(original.path, tmp_path / "campaign"), original.python)


def planned(folder, *flags: str) -> dict[str, int]:
    """Return the jobs by rule of a dry run, without their sum."""
    run = folder.snakemake("--dry-run", *flags)
    assert run.status == 0, run.text
    return {rule: count for rule, count in run.jobs.items() if rule != "total"}


def edit(folder, name: str, old: str, new: str):
    """Replace a text that is once in a file of the campaign."""
    text = (folder.path / name).read_text()
    assert text.count(old) == 1, text
    (folder.path / name).write_text(text.replace(old, new))


def test_nothing_runs_again_where_nothing_changed(finished):
    assert planned(finished) == {}


def test_a_changed_cell_reruns_its_case_alone(finished):
    edit(finished, "cases.tsv", "prescribed\t\n", "prescribed\t0.6\n")
    assert planned(finished) == times(3, {"crack": 1} | STAGES) | LAST


def test_a_column_of_empty_cells_reruns_nothing(finished):
    text = (finished.path / "cases.tsv").read_text().splitlines()
    rows = [text[0] + "\tinp.load", *(row + "\t" for row in text[1:])]
    (finished.path / "cases.tsv").write_text("\n".join(rows))
    assert planned(finished) == {}


def test_a_changed_load_reruns_decks_and_not_meshes(finished):
    edit(finished, "cases.tsv", "sizing.l_min", "inp.magnitude")
    edit(finished, "cases.tsv", "prescribed\t\n", "prescribed\t0.002\n")
    assert planned(finished) == {"inp": 3, "all": 1}


def test_a_longer_sweep_runs_its_new_case_alone(finished):
    edit(finished, "cases.tsv", "prescribed\t\n", "prescribed\t[0.6]\n")
    assert finished.snakemake("--cores", "2").status == 0
    edit(finished, "cases.tsv", "[0.6]", "[0.6, 0.8]")
    new = {"generate": 1, "import_microstructure": 1, "remesh": 1, "crack": 3}
    assert planned(finished) == new | times(3, STAGES) | LAST

"""What runs again after a change, by the counts of a dry run on a finished campaign."""

import re
import shutil
from pathlib import Path

import pytest

from craftmesh.cli import main

ROOT = Path(__file__).resolve().parents[2]
CASES = """case\tmicrostructure\tcrack\tincrements\tgrowth\tsizing.l_min
notch\tsynthetic\ttiny\t3\tprescribed\t
grown\tsynthetic\ttiny\t2\tgrow\t
"""
# stages of an increment from sizes to the deck, by their jobs
STAGES = {"size": 1, "stitch": 1, "gradate": 1, "tetrahedralize": 2, "assemble": 1, "inp": 1, "check": 1}
STAGES |= {"depict": 1}
LAST = {"report": 1, "all": 1}
# a crack that no case has, whose file's name alone is more than a command line holds
UNUSED = f"  long: {{shape: surface, file: {'x' * 140_000}}}\n"


@pytest.fixture(scope="module")
def original(new_folder, idle_python):
    """A finished campaign of two cases, whose files hold no meshes; its report is told of 140 kB."""
    folder = new_folder(CASES, python=idle_python)
    with open(folder.path / "config.yaml", "a") as stream:
        stream.write(UNUSED)
    run = folder.snakemake("--cores", "2")
    assert run.status == 0, run.text
    return folder


@pytest.fixture
def finished(original, tmp_path):
    """A copy of it to be changed."""
    return type(original)(shutil.copytree(original.path, tmp_path / "campaign"), original.python)


def planned(folder, *flags: str) -> dict[str, int]:
    """Return the jobs by rule of a dry run, by the copy of the project in the folder where there is one."""
    project = folder.path / "project"
    run = folder.snakemake("--dry-run", *flags, project=project if project.is_dir() else ROOT)
    assert run.status == 0, run.text
    return {rule: count for rule, count in run.jobs.items() if rule != "total"}


def edit(folder, name: str, old: str, new: str):
    """Replace a text that is once in a file of the campaign."""
    text = (folder.path / name).read_text()
    assert text.count(old) == 1, text
    (folder.path / name).write_text(text.replace(old, new))


def rows(section: str) -> list[list[str]]:
    """Return the cells of the table in a section of the cookbook, without its head."""
    text = (ROOT / "docs" / "reruns.md").read_text().partition(f"## {section}")[2].partition("\n## ")[0]
    lines = [line for line in text.splitlines() if line.startswith("| ")][1:]
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines]


def jobs(cell: str) -> dict[str, int]:
    return {rule: int(count) for rule, count in re.findall(r"(\w+) (\d+)", cell)}


def flags(cell: str) -> list[str]:
    """Return the flags of a command of the cookbook."""
    snakemake, *words = cell.strip("`").split()
    assert snakemake == "snakemake"
    return words


@pytest.mark.slow  # 7 s each; the commonest changes are in test_campaign_run as well
@pytest.mark.parametrize(("command", "wanted"), [row[1:] for row in rows("By hand")])
def test_commands_of_the_cookbook_plan_the_jobs_that_it_names(original, command, wanted):
    assert planned(original, *flags(command)) == jobs(wanted)


def sheet(old: str, new: str):
    return lambda folder: edit(folder, "cases.tsv", old, new)


def module(path: str):
    """Return a change: one comment more in a module of a copy of the project."""

    def touch(folder):
        project = folder.path / "project"
        for part in ("craftmesh", "workflow", "profiles"):
            shutil.copytree(ROOT / part, project / part, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copy(ROOT / "Snakefile", project)
        with open(project / path, "a") as stream:
            stream.write("\n# touched\n")

    return touch


def configuration(text: str):
    def add(folder):
        with open(folder.path / "config.yaml", "a") as stream:
            stream.write(text)

    return add


CHANGES = {
    "nothing": lambda folder: None,
    "`inp.magnitude` in the configuration": configuration("inp: {magnitude: 0.002}\n"),
    "`gradate.passes` in the configuration": configuration("gradate: {passes: 5}\n"),
    "`inp.magnitude` of the case `notch` in the case table": sheet(
        CASES, CASES.replace("sizing.l_min", "inp.magnitude").replace("prescribed\t", "prescribed\t0.002")
    ),
    "`sizing.l_min` of the case `notch` in the case table": sheet("prescribed\t", "prescribed\t0.6"),
    "a fourth increment of `notch`": sheet("tiny\t3", "tiny\t4"),
    "a third increment of `grown`": sheet("tiny\t2", "tiny\t3"),
    "a new case of one increment": sheet("grow\t\n", "grow\t\nnew\tsynthetic\ttiny\t1\tprescribed\t\n"),
    "the case `notch` taken out": sheet("notch\t", "#notch\t"),
    "the module `craftmesh/gradation/gradate.py`": module("craftmesh/gradation/gradate.py"),
    "the module `craftmesh/mesh/quality.py`": module("craftmesh/mesh/quality.py"),
}


@pytest.mark.slow  # 7 s each; the commonest changes are in test_campaign_run as well
@pytest.mark.parametrize(("change", "wanted"), rows("After a change"))
def test_changes_of_the_cookbook_plan_the_jobs_that_it_names(finished, change, wanted):
    CHANGES[change](finished)
    assert planned(finished) == jobs(wanted)


@pytest.mark.slow
def test_what_is_there_is_accepted(finished):
    all_of_it, some_of_it, for_once = (flags(command) for _, command, _ in rows("Accept what is there"))
    sheet("prescribed\t", "prescribed\t0.6")(finished)
    changed = planned(finished)
    assert changed["size"] == 3 and planned(finished, *for_once) == {}
    assert finished.snakemake(*some_of_it).status == 0
    left = planned(finished)
    assert left["size"] == left["gradate"] == 2
    assert finished.snakemake(*all_of_it).status == 0
    assert planned(finished) == {}


@pytest.mark.slow
def test_nothing_runs_again_after_a_clean(finished, monkeypatch, capsys):
    monkeypatch.chdir(finished.path)
    parts = Path("results", "grown", "001", "tets")
    assert parts.is_dir()
    assert main(["clean", "results", "-n"]) == 0 and parts.is_dir()
    assert main(["clean", "results"]) == 0 and not parts.exists()
    assert main(["status", "results"]) == 0
    told = capsys.readouterr().out.splitlines()
    assert told[-3:-1] == ["grown: all is made", "notch: all is made"]
    assert planned(finished) == {}


@pytest.mark.slow
def test_a_longer_sweep_runs_its_new_case_alone(finished):
    edit(finished, "cases.tsv", "prescribed\t\n", "prescribed\t[0.6]\n")
    assert finished.snakemake("--cores", "2").status == 0
    edit(finished, "cases.tsv", "[0.6]", "[0.6, 0.8]")
    new = {"generate": 1, "import_microstructure": 1, "remesh": 1, "crack": 3}
    assert planned(finished) == new | {rule: 3 * count for rule, count in STAGES.items()} | LAST

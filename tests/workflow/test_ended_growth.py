"""A case whose crack ends, or fails to grow, before its last increment."""

import pytest

CASES = (
    "case\tmicrostructure\tcrack\tincrements\tgrowth\na\tsynthetic\ttiny\t4\t{}\nb\tsynthetic\ttiny\t1\t\n"
)


def decks(folder):
    return sorted(
        str(path.parent.relative_to(folder.path / "results")) for path in folder.path.rglob("model.inp")
    )


@pytest.mark.parametrize("word", ["grow", "until"])
def test_a_crack_that_ends_by_itself_is_no_failure(new_folder, idle_python, monkeypatch, word):
    monkeypatch.setenv("ENDS", "001")
    folder = new_folder(CASES.format(word), python=idle_python)
    run = folder.snakemake("--cores", "2")
    assert run.status == 0, run.text
    assert decks(folder) == ["a/000", "a/001", "b/000"]
    assert folder.snakemake("--dry-run").jobs == {}


def test_a_growth_that_fails_keeps_no_deck_from_being_made(new_folder, idle_python, monkeypatch):
    monkeypatch.setenv("ENDS", "-001")
    folder = new_folder(CASES.format("grow"), python=idle_python)
    run = folder.snakemake("--cores", "2")
    assert run.status == 1 and "no room" in run.text
    assert decks(folder) == ["a/000", "a/001", "b/000"]

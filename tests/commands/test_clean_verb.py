"""`craftmesh clean`: what the mesh holds in another form goes, and nothing while a campaign runs."""

import json
import os

import pytest

from craftmesh.campaign.case_status import jobs
from craftmesh.cli import main
from craftmesh.report.case_files import STAGES

RECORD = {"campaign": "s", "microstructure": "v.npz", "cracks": [], "increments": 1, "growth": "prescribed"}


@pytest.fixture
def results(tmp_path, monkeypatch):
    """Results of a case that is whole, and of one that lacks its pictures."""
    monkeypatch.chdir(tmp_path)
    for case in ("whole", "begun"):
        for job in jobs(RECORD, 1):
            path = tmp_path / "results" / case / job.increment / STAGES[job.name].made
            if job.name in ("tets", "pictures"):
                path = path / "1-of-1.npz"
            if (case, job.name) != ("begun", "pictures"):
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(bytes(1_000_000))
        log = tmp_path / "results" / "logs" / case / "000" / "tets" / "1-of-1.log"
        log.parent.mkdir(parents=True)
        log.touch()
        os.utime(log, (1, 1))
        (tmp_path / "results" / case / "case.json").write_text(json.dumps(RECORD))
    return tmp_path / "results"


def files(results):
    return {str(path.relative_to(results)) for path in results.rglob("*") if path.is_file()}


def test_what_the_mesh_holds_in_another_form_is_removed_of_whole_cases_alone(results, capsys):
    before = files(results)
    assert main(["clean", "results", "--dry-run"]) == 0 and files(results) == before
    assert capsys.readouterr().out.endswith("3.0 MB can be freed\n")
    assert main(["clean", "results"]) == 0
    gone = {"whole/000/surface.vtp", "whole/000/gradated.vtp", "whole/000/tets/1-of-1.npz"}
    assert before - files(results) == gone
    capsys.readouterr()
    assert main(["clean", "results"]) == 0
    assert capsys.readouterr().out == "0.0 MB freed\n"


def test_a_case_stays_whole_once_it_was_cleaned(results, capsys):
    assert main(["clean", "results"]) == 0
    capsys.readouterr()
    assert main(["status", "results"]) == 0
    assert "whole: all is made" in capsys.readouterr().out
    (results / "logs" / "whole" / "000" / "gradated.log").touch()  # it runs again
    assert main(["status", "results"]) == 0
    assert "whole: increment 000 (1 of 1), gradate" in capsys.readouterr().out


def test_nothing_is_removed_while_a_campaign_runs_here(results, capsys):
    lock = results.parent / ".snakemake" / "locks" / "0.output.lock"
    lock.parent.mkdir(parents=True)
    lock.touch()
    before = files(results)
    assert main(["clean", "results"]) == 1 and files(results) == before
    assert "--unlock" in capsys.readouterr().err


def test_what_killed_jobs_left_unfinished_is_removed_of_all_cases(results):
    before = files(results)
    for name in (
        "begun/000/.tmp-0123456789ab-volume.vtu",
        "begun/001/.tmp-0123456789ab-pictures/sizes.svg",
    ):
        (results / name).parent.mkdir(parents=True, exist_ok=True)
        (results / name).touch()
    assert main(["clean", "results"]) == 0
    assert {name for name in files(results) if "begun" in name} == {n for n in before if "begun" in n}
    assert list(results.rglob(".tmp-*")) == []

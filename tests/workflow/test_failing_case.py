"""A case that fails: its line at the end of the run, records, and a page that says so."""

import os
import subprocess
import sys

CASES = "case\tmicrostructure\tcrack\tincrements\nbroken\tv.npz\tnone\t1\n"


def craftmesh(folder, *words):
    """Run a verb in a folder; return its status, what it printed and what it warned of."""
    command = [sys.executable, "-m", "craftmesh.cli", *words]
    done = subprocess.run(command, cwd=folder, env=os.environ, capture_output=True, text=True, timeout=300)
    return done.returncode, done.stdout, done.stderr


def test_a_failed_run_says_why_and_leaves_records_and_a_page(new_folder):
    folder = new_folder(CASES).path
    (folder / "v.npz").write_text("no archive")
    status, printed, told = craftmesh(
        folder, "run", "config.yaml", "--cores", "1", "--snakemake", "--nocolor"
    )
    assert status == 1, told
    results = folder / "results"
    assert (results / "broken" / "case.json").is_file()
    log = (results / "logs" / "broken" / "microstructure.log").read_text().strip()
    assert log.startswith("craftmesh: error: ")
    why = log.removeprefix("craftmesh: error: ")
    assert printed.splitlines() == [
        f"broken: failed, broken/microstructure.log: {why}",
        "0 of 1 cases made; see results/report.html",
    ]
    page = (results / "report.html").read_text()
    assert "broken/microstructure.log" in page and "v.npz" in page
    assert craftmesh(folder, "status", "results")[1].startswith("broken: failed, ")


def test_a_refused_campaign_is_one_line(new_folder):
    folder = new_folder(CASES).path
    status, printed, told = craftmesh(folder, "run", "config.yaml")
    assert status == 1 and printed == ""
    error = told.splitlines()[-1]
    assert error.startswith("craftmesh: error: ") and "v.npz" in error and "does not exist" in error

"""A case that fails leaves a page that says so."""

from pathlib import Path

WORKFLOW = Path(__file__).resolve().parents[2] / "workflow" / "Snakefile"
CASES = "case\tmicrostructure\tcrack\tincrements\nbroken\tv.npz\tnone\t1\n"


def test_a_failed_run_leaves_records_and_a_page(new_folder, run_snakemake):
    folder = new_folder(CASES)
    (folder.path / "v.npz").write_text("no archive")
    flags = ("-s", str(WORKFLOW), "--cores", "1", "--configfile", "config.yaml", "--nocolor")
    run = run_snakemake(folder.path, *flags)
    assert run.status == 1, run.text
    results = folder.path / "results"
    assert (results / "broken" / "case.json").is_file()
    log = (results / "logs" / "broken" / "microstructure.log").read_text().strip()
    assert log.startswith("craftmesh: error: ")
    page = (results / "report.html").read_text()
    assert "broken/microstructure.log" in page and "v.npz" in page

"""The ways into the workflow: both Snakefiles, a module of three lines, and what each of them runs."""

import re
import shutil
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
WORKFLOW = ROOT / "workflow" / "Snakefile"
MODULE = f'''module craftmesh:
    snakefile: "{WORKFLOW}"
use rule * from craftmesh
'''
OWN = "cases: mine.tsv\nresults: mine\nsizing: {l0: 1.5}\n"
OWN_CASES = "case\tmicrostructure\tcrack\tincrements\nbare\tsynthetic\tnone\t1\n"
DEMO_JOBS = {"generate": 1, "crack": 3, "size": 3, "tetrahedralize": 6, "inp": 3, "all": 1}
DEMO_JOBS |= {"solve": 3, "fracture": 3, "grow": 2, "depict": 3, "total": 43}


@pytest.fixture(params=["root", "workflow", "module"])
def entry(request, tmp_path) -> tuple[Path, tuple[str, ...]]:
    """An empty folder and the flags of one entry; a module is a Snakefile of three lines."""
    if request.param == "module":
        (tmp_path / "Snakefile").write_text(MODULE)
        return tmp_path, ()
    return tmp_path, ("-s", str({"root": ROOT / "Snakefile", "workflow": WORKFLOW}[request.param]))


def flags_of(text: str, verb: str) -> str:
    """Return what the plan of a run calls `craftmesh verb` with."""
    return next(line for line in text.splitlines() if f"craftmesh {verb} " in line)


def test_each_entry_plans_the_demo_in_an_empty_folder(entry, run_snakemake):
    folder, flags = entry
    run = run_snakemake(folder, *flags, "--dry-run", "--printshellcmds", "--config", "results=elsewhere")
    assert run.status == 0, run.text
    assert DEMO_JOBS.items() <= run.jobs.items()
    assert "--l-min 0.9" in flags_of(run.text, "size") and " -o elsewhere/demo/" in run.text
    if flags:  # a module's Snakefile has its own, or none
        assert "workflow specific profile" in run.text  # by which a failed job's log is shown


def test_a_module_plans_a_campaign_of_ones_own_without_values_of_the_demo(tmp_path, run_snakemake):
    (tmp_path / "Snakefile").write_text(MODULE)
    (tmp_path / "own.yaml").write_text(OWN)
    (tmp_path / "mine.tsv").write_text(OWN_CASES)
    run = run_snakemake(tmp_path, "--dry-run", "--printshellcmds", "--configfile", "own.yaml")
    assert run.status == 0, run.text
    assert run.jobs["inp"] == 1 and "crack" not in run.jobs
    assert "--l-min 0.9" not in run.text and "--grains 20" not in flags_of(run.text, "generate")
    assert " -o mine/bare/" in flags_of(run.text, "generate")


def test_module_takes_the_configuration_of_its_snakefile(tmp_path, run_snakemake):
    (tmp_path / "own.yaml").write_text(OWN)
    (tmp_path / "mine.tsv").write_text(OWN_CASES)
    text = MODULE.replace("use rule", "    config: config\nuse rule")
    (tmp_path / "Snakefile").write_text('configfile: "own.yaml"\n' + text)
    run = run_snakemake(tmp_path, "--dry-run", "--config", "results=there")
    assert run.status == 0, run.text
    assert run.jobs["inp"] == 1 and "there/bare/000/model.inp" in run.text


def test_small_campaign_of_the_tree_is_planned(tmp_path, run_snakemake):
    shutil.copytree(ROOT / ".test" / "config", tmp_path / "config")
    run = run_snakemake(ROOT, "--dry-run", "--directory", str(tmp_path))
    assert run.status == 0, run.text
    assert run.jobs["inp"] == run.jobs["tetrahedralize"] == 1 and "results/small/000/model.inp" in run.text


def test_missing_package_is_one_line(tmp_path, run_snakemake):
    hidden = tmp_path / "hidden" / "craftmesh"
    hidden.mkdir(parents=True)
    (hidden / "__init__.py").write_text("raise ModuleNotFoundError('there is none', name='craftmesh')")
    run = run_snakemake(tmp_path, "-n", "-s", str(WORKFLOW), env={"PYTHONPATH": str(hidden.parent)})
    lines = [line for line in run.text.splitlines() if "craftmesh" in line]
    assert run.status == 1 and len(lines) == 1, run.text
    assert "cannot import craftmesh (there is none)" in lines[0] and "-m pip install" in lines[0]
    assert "Traceback" not in run.text


def test_snakemakes_linter_finds_nothing(tmp_path, run_snakemake):
    run = run_snakemake(tmp_path, "--lint", "-s", str(WORKFLOW))  # the root's: make lint
    assert run.status == 0 and "Lints for" not in run.text, run.text


@pytest.mark.parametrize(("flags", "limit"), [((), None), (("--max-jobs-per-timespan", "50/1s"), 50)])
def test_starts_of_jobs_have_no_limit_but_the_users(flags, limit, new_folder, idle_python):
    """Under a limit each started job adds a timer that asks the scheduler each second from then on."""
    asked = ("--cores", "1", "--verbose", "--until", "generate", *flags)
    run = new_folder(python=idle_python).snakemake(*asked)
    assert run.status == 0, run.text
    after = re.search(r"Resources after job selection:.*'_job_count': (\d+)", run.text)
    assert after is not None
    assert int(after[1]) == (limit or sys.maxsize)

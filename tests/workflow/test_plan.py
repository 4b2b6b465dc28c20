"""What Snakemake plans, and what it refuses, before any job runs."""

import json
import re
import shutil
from pathlib import Path

import pytest
import yaml

from craftmesh.campaign.campaign import SCHEMAS
from craftmesh.campaign.config_schema import config_schema

ROOT = Path(__file__).resolve().parents[2]
PER_CASE = {"generate": 1, "import_microstructure": 1, "remesh": 1}
PER_INCREMENT = {
    "crack": 1,
    "size": 1,
    "stitch": 1,
    "gradate": 1,
    "tetrahedralize": 2,
    "assemble": 1,
    "inp": 1,
    "check": 1,
    "depict": 1,
}
HEADER = "case\tmicrostructure\tcrack\tincrements\n"
GROWING = "case\tmicrostructure\tcrack\tincrements\tgrowth\n"


def test_plan_of_a_new_campaign(new_folder):
    cases = HEADER + "a\tsynthetic\ttiny\t3\nb\tsynthetic\ttiny\t1\nc\tsynthetic\tnone\t1\n"
    run = new_folder(cases).snakemake("--dry-run")
    wanted = {rule: 3 * count for rule, count in PER_CASE.items()}
    wanted |= {rule: 5 * count for rule, count in PER_INCREMENT.items()}
    wanted |= {"crack": 4, "report": 1, "all": 1}
    assert run.status == 0, run.text
    assert run.jobs == wanted | {"total": sum(wanted.values())}
    assert "craftmesh: note: case a and 1 more: crack tiny has size 3.5" in run.text


def test_plan_of_a_crack_that_grows(new_folder):
    cases = GROWING + "a\tsynthetic\ttiny\t3\tgrow\nb\tsynthetic\ttiny\t2\tprescribed\n"
    run = new_folder(cases).snakemake("--dry-run", "--printshellcmds")
    assert run.status == 0, run.text
    assert {rule: run.jobs[rule] for rule in ("solve", "fracture", "grow", "crack", "inp")} == {
        "solve": 3,
        "fracture": 3,
        "grow": 2,
        "crack": 5,
        "inp": 5,
    }
    decks = [line for line in run.text.splitlines() if "craftmesh inp " in line]
    assert all(("results/a/" in line) == ("--quarter-points" in line) for line in decks)


def test_a_dry_run_of_a_growing_crack_ends_where_the_crack_ended(new_folder):
    folder = new_folder(GROWING + "a\tsynthetic\ttiny\t9\tuntil\n")
    assert folder.snakemake("--dry-run").jobs["inp"] == 9
    for inc, ended in (("000", ""), ("001", "every front has left the body")):
        report = folder.path / f"results/a/{inc}/growth.json"
        report.parent.mkdir(parents=True)
        report.write_text(json.dumps({"ended": ended}))
    run = folder.snakemake("--dry-run")
    assert run.status == 0, run.text
    assert run.jobs["inp"] == run.jobs["solve"] == 2


def test_intensities_of_prescribed_cracks_are_a_target(new_folder):
    run = new_folder().snakemake("--dry-run", "intensities")
    assert run.status == 0, run.text
    assert run.jobs["solve"] == run.jobs["fracture"] == 2 and "inp" not in run.jobs


def test_a_configuration_without_sizes_takes_them_from_the_voxels(new_folder):
    folder = new_folder(HEADER + "a\tsynthetic\tnone\t1\n", "cases: cases.tsv\n")
    run = folder.snakemake("--dry-run", "--printshellcmds")
    assert run.status == 0 and run.jobs["size"] == run.jobs["inp"] == 1, run.text
    (command,) = [line for line in run.text.splitlines() if "craftmesh size " in line]
    assert "--labels results/a/labels.npz" in command and "--l0" not in command
    for verb in ("stitch", "gradate", "tetrahedralize", "assemble"):
        commands = [line for line in run.text.splitlines() if f"craftmesh {verb} " in line]
        assert commands and all("--sizing results/a/000/sizing.npz" in command for command in commands)


def test_a_solution_and_parameters_along_the_front_are_made_where_a_target_asks_for_them(new_folder):
    run = new_folder().snakemake("--dry-run", "--printshellcmds", "results/tiny/001/sif.csv")
    assert run.status == 0 and run.jobs["fracture"] == run.jobs["solve"] == 1, run.text
    assert "inp" not in run.jobs
    solve, fracture = (
        next(line for line in run.text.splitlines() if f"craftmesh {verb} " in line)
        for verb in ("solve", "fracture")
    )
    assert "--element C3D10" in solve and "includes" not in solve and "--solver builtin" in solve
    assert "--element C3D10" in fracture and "--radius 4.0" in fracture and "--probe" not in fracture


def test_a_partition_that_python_knows_is_taken_in_quotes(new_folder):
    folder = new_folder()
    run = folder.snakemake("--dry-run", "--default-resources", "slurm_partition='all'")
    assert run.status == 0 and "slurm_partition=all" in run.text, run.text


def test_slurm_profile_plans_the_same_jobs_in_groups(new_folder):
    folder = new_folder()
    run = folder.snakemake("--dry-run", "--profile", str(ROOT / "profiles" / "slurm"))
    assert run.status == 0, run.text
    wanted = PER_CASE | {rule: 2 * count for rule, count in PER_INCREMENT.items()} | {"report": 1, "all": 1}
    assert run.jobs == wanted | {"total": sum(wanted.values())}
    for inc in ("000", "001"):
        assert f"Group job surface_tiny_{inc}" in run.text and f"Group job deck_tiny_{inc}" in run.text


def test_a_mistake_stops_the_campaign_with_one_line(new_folder):
    folder = new_folder(HEADER + "a\tsynthetic\ttiny\t1\n" * 2)
    before = sorted(path.name for path in folder.path.iterdir())
    run = folder.snakemake("--cores", "1")
    errors = [text for text in run.text.splitlines() if "error" in text.lower()]
    assert run.status == 1
    assert len(errors) == 1 and errors[0].startswith("craftmesh: error: ")
    assert "duplicate case name 'a'" in errors[0]
    after = sorted(path.name for path in folder.path.iterdir() if path.name != ".snakemake")
    assert after == before


def test_schema_is_made_from_the_option_classes():
    path = SCHEMAS / "config.schema.yaml"
    assert yaml.safe_load(path.read_text()) == config_schema(), (
        f"run `python -m craftmesh.campaign.config_schema {path.relative_to(ROOT)}`"
    )


def test_default_configuration_names_and_explains_every_key():
    text = (ROOT / "config" / "config.yaml").read_text()
    given = yaml.safe_load(text)
    for key, schema in config_schema()["properties"].items():
        assert key in given, f"config/config.yaml does not name {key}"
        missing = set(schema.get("properties", ())) - set(
            given[key] if isinstance(given[key], dict) else ()
        )
        assert not missing, f"config/config.yaml does not name {sorted(missing)} of {key}"
    lines = ["", *text.splitlines()]
    bare = [line for above, line in zip(lines, lines[1:]) if line.strip() and "#" not in above + line]
    assert not bare, f"keys without a comment: {bare}"


@pytest.mark.parametrize(
    ("name", "increments"), [("al1050", 3), ("al6xn", 3), ("copper", 3), ("intergranular", 2)]
)
def test_examples_are_complete(name, increments, shared_data, new_folder):
    folder = new_folder()
    for part in ("config", f"examples/{name}"):
        shutil.copytree(ROOT / part, folder.path / part)
    example = f"examples/{name}/config.yaml"
    run = folder.snakemake("--dry-run", "--config", f"data={shared_data}", configfile=example)
    assert run.status == 0, run.text
    assert run.jobs["inp"] == increments and "generate" not in run.jobs


@pytest.mark.parametrize("name", ["al1050", "copper"])
def test_examples_that_grow_are_complete(name, shared_data, new_folder):
    folder = new_folder()
    shutil.copytree(ROOT / "examples" / name, folder.path / "examples" / name)
    example = f"examples/{name}/growth.yaml"
    run = folder.snakemake("--dry-run", "--config", f"data={shared_data}", configfile=example)
    assert run.status == 0, run.text
    assert {rule: run.jobs[rule] for rule in ("inp", "solve", "grow")} == {"inp": 5, "solve": 5, "grow": 4}


def test_earlier_cases_come_first_and_in_a_case_earlier_increments(new_folder):
    cases = (
        GROWING
        + "c\tsynthetic\ttiny\t3\tgrow\na\tsynthetic\ttiny\t2\tprescribed\nb\tsynthetic\tnone\t1\t\n"
    )
    text = new_folder(cases).snakemake("--dry-run").text
    jobs = re.findall(
        r"output: results/(\w)/(\d{3}/)?([^,\s]*).*?\n(?:\s+\w+: .*\n)*?\s+priority: ([\d.]+)", text
    )
    assert len(jobs) > 50
    spans = {case: [float(x) for one, *_, x in jobs if one == case] for case in "cab"}
    assert min(spans["c"]) > max(spans["a"]) > min(spans["a"]) > max(spans["b"]) > 0
    decks = {(case, inc): float(x) for case, inc, name, x in jobs if name == "model.inp"}
    assert decks["c", "000/"] > decks["c", "001/"] > decks["c", "002/"]
    by_name = {name: float(x) for case, inc, name, x in jobs if (case, inc) == ("c", "000/")}
    assert by_name["solution.npz"] > by_name["model.inp"] > by_name["pictures"]

"""Which stages run again when files that they read change, by dry runs on a finished campaign."""

import os
import re
from pathlib import Path

import numpy as np
import pytest
import tifffile
import yaml

from craftmesh.campaign.campaign import read_campaign
from craftmesh.campaign.content import content
from craftmesh.campaign.file_digest import digest_of

SHEET = """case\tmicrostructure\tcrack\tincrements\tsizing.points\tinp.lip_field\tinp.user_material
header\tv.mhd\tcloud\t1\t\t\t
slices\tslices\tseries\t2\t\tlips.csv\t
sized\tslices\tnone\t1\tpoints.csv\t\t
loaded\tslices\tnone\t1\t\t\town.yaml
"""
CONFIG = """
cases: cases.tsv
chunks: 1
import: {spacing: [1, 1, 1]}
sizing: {l0: 1.5, l_min: 1.0, l_max: 3.0, r0: 2.0, r1: 4.0}
cracks:
  series: {shape: fronts, increments: [front0.csv, front1.csv]}
  cloud: {shape: points, file: cloud.ply, front: front0.csv}
"""
TEMPLATE = "constants: 1\nvalues: [1.0]\n"
# what a change of each file runs again: stages of cases and increments
READ_BY = {
    "v.raw": {"import_microstructure header"},
    "slices/s_1.tif": {f"import_microstructure {case}" for case in ("slices", "sized", "loaded")},
    "points.csv": {"size sized 000"},
    "own.yaml": {"inp loaded 000"},
    "lips.csv": {"inp slices 000", "inp slices 001"},
    "front0.csv": {"crack slices 000", "crack slices 001", "crack header 000"},
    "front1.csv": {"crack slices 001"},
    "cloud.ply": {"crack header 000"},
}


@pytest.fixture(scope="module")
def finished(new_folder, idle_python):
    """A finished campaign whose results hold no meshes."""
    folder = new_folder(SHEET, CONFIG, idle_python)
    write_files(folder.path)
    run = folder.snakemake("--cores", "2")
    assert run.status == 0, run.text
    return folder


def write_files(path: Path) -> None:
    data = np.arange(8, dtype=np.uint8)
    (path / "v.raw").write_bytes(data.tobytes())
    (path / "v.mhd").write_text("DimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = v.raw\n")
    (path / "slices").mkdir()
    for k in range(2):
        tifffile.imwrite(path / f"slices/s_{k}.tif", data.reshape(2, 4) + k, photometric="minisblack")
    for name in ("points.csv", "lips.csv", "front0.csv", "front1.csv", "cloud.ply"):
        (path / name).write_text("x,y,z\n1,2,3\n")
    (path / "own.yaml").write_text(TEMPLATE)


def planned(folder) -> set[str]:
    """Return the jobs that run for a reason of their own, not because one before them does."""
    run = folder.snakemake("--dry-run")
    assert run.status == 0, run.text
    jobs = re.findall(r"rule (\w+):.*?reason: ([^\n]*)\n\s+wildcards: ([^\n]*)", run.text, re.S)
    return {
        " ".join([rule, *re.findall(r"(?:case|inc)=(\w+)", wildcards)])
        for rule, reason, wildcards in jobs
        if not reason.startswith("Input files updated by another job")
    }


def replace(file: Path) -> None:
    """Replace a file by one of other content that is older than the results."""
    content, other = file.read_bytes(), file.with_name("other")
    is_text = file.suffix in (".csv", ".ply")
    other.write_bytes(content.replace(b"3\n", b"4\n") if is_text else content + b" ")
    os.utime(other, (1e9, 1e9))
    os.replace(other, file)


def contents(path: Path) -> dict[str, str | None]:
    """Return what is in the files of each stage of each case and increment."""
    digest_of.cache_clear()
    campaign = read_campaign(yaml.safe_load((path / "config.yaml").read_text()))
    found = {}
    for name, case in campaign.cases.items():
        found[f"import_microstructure {name}"] = content(campaign, "import_", name)
        for inc in case.increment_names:
            stages = ("size", "inp", *["crack"] * bool(case.cracks))
            found |= {f"{stage} {name} {inc}": content(campaign, stage, name, inc) for stage in stages}
    return found


def test_stages_run_again_for_other_content_and_not_for_other_times(finished):
    for name in READ_BY:
        os.utime(finished.path / name, (4e9, 4e9))
    assert planned(finished) == set()
    for name in ("v.raw", "points.csv", "own.yaml", "front0.csv"):
        replace(finished.path / name)
    assert planned(finished) == {  # what follows these is no reason of its own
        "import_microstructure header",
        "size sized 000",
        "inp loaded 000",
        "crack slices 000",
    }


@pytest.mark.parametrize("name", READ_BY)
def test_each_file_is_tracked_by_the_stages_that_read_it(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "config.yaml").write_text(CONFIG)
    (tmp_path / "cases.tsv").write_text(SHEET)
    write_files(tmp_path)
    before = contents(tmp_path)
    replace(tmp_path / name)
    after = contents(tmp_path)
    assert {stage for stage in before if before[stage] != after[stage]} == READ_BY[name]


@pytest.mark.parametrize(
    ("solve", "file", "tracked"),
    [
        ({"solver": "external"}, "results/slices/000/field.csv", True),
        ({"solver": "external"}, "results/slices/001/field.csv", False),
        ({"solver": "builtin"}, "results/slices/000/field.csv", False),
        ({"solver": "calculix", "command": ["ccx_umat user={here}/umat.f {job}"]}, "umat.f", True),
        ({"solver": "calculix", "command": ["{here}/umat.f -i {job}"]}, "umat.f", True),
        ({"solver": "calculix", "command": ["umat.f -i {job}"]}, "umat.f", False),  # one on the PATH
    ],
)
def test_fields_and_programs_of_other_solvers_are_tracked(solve, file, tracked, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cases.tsv").write_text(SHEET.replace("own.yaml", ""))
    write_files(tmp_path)
    calls = [call.replace("{here}", str(tmp_path)) for call in solve.get("command", [])]
    config = yaml.safe_load(CONFIG) | {"solve": solve | {"command": calls}}
    campaign, texts = read_campaign(config), set()
    (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
    for text in ("1", "22"):
        (tmp_path / file).write_text(text)
        digest_of.cache_clear()
        texts.add(content(campaign, "solve", "slices", "000"))
    assert len(texts) == 1 + tracked

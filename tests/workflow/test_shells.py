"""What rules hand to a shell arrives at commands as it was, whatever is in paths and values."""

import json
import os
import re
import subprocess
from pathlib import Path

import pytest

from craftmesh.campaign.campaign import command_flags

RULES = Path(__file__).resolve().parents[2] / "workflow" / "rules"
ODD = 'it\'s "a" $(touch ran) `touch ran`; touch ran & (1) *?[ä] $HOME α'
RESULTS = f"results {ODD}".replace("$HOME", "$")  # variables are expanded in what is written


def rules_with_shells():
    for path in sorted(RULES.glob("*.smk")):
        for text in re.split(r"^(?=rule |checkpoint )", path.read_text(), flags=re.M)[1:]:
            if "    shell:\n" in text:
                yield pytest.param(text, id=re.match(r"\w+ (\w+):", text)[1])


@pytest.mark.parametrize("text", list(rules_with_shells()))
def test_every_placeholder_of_a_shell_is_quoted(text):
    """Either by :q, or in the parameter itself, which is then made of flags."""
    head, _, shell = text.partition("    shell:\n")
    for name in re.findall(r"\{([^{}]*)\}", shell):
        made = re.search(rf"^        {name.removeprefix('params.')}=(.*(?:\n   .*)*?)$", head, re.M)
        is_flags = name.startswith("params.") and made and re.search(r"flags?\(", made[1])
        assert name.endswith(":q") or is_flags, f"{{{name}}} is not quoted"


def test_values_of_flags_arrive_as_they_are(tmp_path):
    values = [ODD, "{a} {{b}}", "<logs>", "-x", "a\nb"]
    flags = command_flags({"file": values})
    done = subprocess.run(["bash", "-c", f"printf '%s\\0' {flags}"], capture_output=True, cwd=tmp_path)
    assert done.stdout.decode().split("\0")[1:-1] == values and not any(tmp_path.iterdir())


@pytest.fixture(scope="module")
def odd_folder(new_folder, idle_python):
    """A campaign whose every path is odd, in an odd folder, run by a command that writes down its words."""
    folder = new_folder(python=idle_python)
    place = folder.path / ODD
    place.mkdir()
    for name in ("v.npz", "crack.stl", "points.csv"):
        (place / f"{ODD}{name}").touch()
    config = {
        "cases": f"{ODD}.tsv",
        "results": RESULTS,
        "data": str(place),
        "chunks": 1,
        "exports": ["vtu"],
        "sizing": {"l0": 1.0, "points": f"{ODD}points.csv"},
        "cracks": {"odd": {"shape": "surface", "file": f"{ODD}crack.stl"}},
        "import": {"dataset": ODD},
    }
    header = "case\tmicrostructure\tcrack\tincrements\tgrowth\n"
    micro = f"{ODD}v.npz".replace('"', '""')
    (place / f"{ODD}.tsv").write_text(f'{header}Gefüge_α\t"{micro}"\todd\t2\tgrow\n')
    (place / "config.json").write_text(json.dumps(config))
    return type(folder)(place, folder.python)


def test_a_campaign_of_odd_paths_runs_to_its_end(odd_folder):
    before = set(os.listdir(odd_folder.path))
    run = odd_folder.snakemake("--cores", "2", configfile="config.json")
    assert run.status == 0, run.text
    results = odd_folder.path / RESULTS
    inputs = json.loads((results / "Gefüge_α" / "labels.npz").read_text())["flags"]
    assert inputs[1] == str(odd_folder.path / f"{ODD}v.npz") and ODD in inputs
    crack = json.loads((results / "Gefüge_α" / "000" / "crack.vtp").read_text())["flags"]
    assert crack[crack.index("--file") + 1] == f"{ODD}crack.stl"
    assert set(os.listdir(odd_folder.path)) - before == {RESULTS, ".snakemake"}
    assert (results / "logs" / "Gefüge_α" / "microstructure.log").is_file()

"""Small meshes with a crack, and folders of results with them, for the report's tests."""

import json
import tempfile
from functools import cache
from pathlib import Path

import numpy as np
from structured_box import plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.cli import main
from craftmesh.io.stage_npz import write_sizing
from craftmesh.io.vtk import write_tets
from craftmesh.mesh.quality import quality
from craftmesh.sizing.sizing import Sizing
from craftmesh.sizing.stored import arrays_of

SHAPE = (6, 4, 4)
AREA = 3.0 * 4.0  # of the crack: from x = 0 to 3, over the whole width


def cracked_box():
    """A box of two grains, with an edge crack of area AREA in the plane z = 2."""
    surface, grains = structured_box(
        SHAPE, lambda centres: 1 + (centres[:, 1] > 2), plane_crack(2, 2, lambda c: c[:, 0] < 3)
    )
    return assemble(surface, grains)[0]


def config(l_min=1.0, **sizing):
    lengths = {"l_min": l_min, "l0": 1.0, "l_max": 2.0, "r0": 1.0, "r1": 2.0}
    return {"sizing": lengths | sizing, "cracks": {"edge": {"shape": "through_edge"}}}


def asked(folder, names, sheet="cases.tsv", increments=1, growth="prescribed", settings=None):
    """Write what the workflow hands to the report for cases of these names, and return the file's name."""
    cases = {
        name: {
            "microstructure": "synthetic",
            "cracks": ["edge"],
            "increments": increments,
            "growth": growth,
            "settings": (settings or {}).get(name, {}),
        }
        for name in names
    }
    (folder / "asked.json").write_text(json.dumps({"campaign": sheet, "config": config(), "cases": cases}))
    return str(folder / "asked.json")


def write_increment(folder, l_min=1.0):
    """Write the files of an increment that the report asks for, those of the cracked box."""
    for name, content in _increment(l_min).items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)


@cache
def _increment(l_min):
    """Return the bytes of those files by name."""
    with tempfile.TemporaryDirectory() as name:
        folder, mesh = Path(name), cracked_box()
        write_tets(folder / "volume.vtu", mesh)
        (folder / "quality.json").write_text(json.dumps({"breaches": []} | quality(mesh)))
        sizing = Sizing(l_min, 1.0, 2.0, 1.0, 2.0, 1.0, np.zeros((1, 3)))
        write_sizing(folder / "sizing.npz", arrays_of(sizing))
        assert main(["depict", str(folder / "volume.vtu"), "-o", str(folder / "pictures")]) == 0
        files = [path for path in folder.rglob("*") if path.is_file()]
        return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def write_front(folder, k_1, flags=("",) * 3):
    """Write a sif.csv of three nodes."""
    rows = ["front,node,s,x,y,z,J,G,K_I,K_II,K_III,T,kink_angle,flags"]
    rows += [f"1,{i},{i},3,{i},2,1,1,{k},0,0,0,{-i},{flags[i]}" for i, k in enumerate(k_1)]
    (folder / "sif.csv").write_text("\n".join(rows) + "\n")

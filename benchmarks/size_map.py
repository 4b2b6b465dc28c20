"""TetGen's program with a size map (.mtr), as a mesher back-end: what was tried before interior points."""

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from measure import load

from craftmesh.tetrahedra.meshers import PROGRAM, MesherRefusal, TetGenProgram, write_smesh

MESHER = "size_map:SizeMapProgram"
SIZING = "CRAFTMESH_BENCHMARK_SIZING"
CELLS = 8
KUHN = np.array([(0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7)])


def missing() -> str:
    """A word on the program, where it is not installed."""
    return "" if shutil.which(PROGRAM) else f"the program {PROGRAM} is not installed"


class SizeMapProgram(TetGenProgram):
    """Meshes with bounds on quality get a background grid with lengths; the file SIZING names has them."""

    def mesh(self, points, facets, markers, interior_points, holes, switches):
        if "q" not in switches:
            return super().mesh(points, facets, markers, interior_points, holes, switches)
        sizing = load(os.environ[SIZING])[1]
        with tempfile.TemporaryDirectory(dir=Path.cwd()) as name:
            folder = Path(name)
            write_smesh(folder / "grain.smesh", points, facets, markers, holes)
            write_background(folder, points.min(axis=0), points.max(axis=0), sizing)
            command = [self.program, f"-{switches}m", "grain.smesh"]
            done = subprocess.run(command, cwd=folder, capture_output=True)
            if done.returncode:
                raise MesherRefusal(f"TetGen ended with status {done.returncode}")
            nodes = np.loadtxt(folder / "grain.1.node", skiprows=1, ndmin=2)[:, 1:4]
            tets = np.loadtxt(folder / "grain.1.ele", skiprows=1, ndmin=2)[:, 1:5].astype(np.int64)
        return np.concatenate([points, nodes[len(points) :]]), tets


def write_background(folder: Path, low: np.ndarray, high: np.ndarray, sizing) -> None:
    """Write grain.b.node, .ele and .mtr: a grid of cubes cut into six, a little larger than the box."""
    margin = 0.05 * (high - low)
    axes = np.linspace(low - margin, high + margin, CELLS + 1).T
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    first = np.stack(np.meshgrid(*[np.arange(CELLS)] * 3, indexing="ij"), -1).reshape(-1, 3)
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)])
    strides = np.array([(CELLS + 1) ** 2, CELLS + 1, 1])
    tets = ((first[:, None] + corners) @ strides)[:, KUHN].reshape(-1, 4)
    numbered = (np.column_stack([np.arange(len(rows)), rows]) for rows in (nodes, tets))
    heads = (f"{len(nodes)} 3 0 0", f"{len(tets)} 4 0")
    for suffix, head, rows, form in zip(("node", "ele"), heads, numbered, (["%d"] + ["%.12g"] * 3, "%d")):
        np.savetxt(folder / f"grain.b.{suffix}", rows, fmt=form, header=head, comments="")
    np.savetxt(folder / "grain.b.mtr", sizing.at(nodes), fmt="%.12g", header=f"{len(nodes)} 1", comments="")

"""Compile the kernels ahead of use: run the stages on small cracked models in a temporary folder.

A kernel is compiled at its first use and kept on disk. Python's modules are kept too, whatever the variable
PYTHONDONTWRITEBYTECODE says. Compile once before many jobs start, because each job would compile them.
`craftmesh run` compiles while its first stages run, in two processes with half of the kernels each.
"""

import argparse
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from craftmesh.cracks.in_plane import triangulate, with_room
from craftmesh.errors import CraftmeshError
from craftmesh.io.front_csv import write_front
from craftmesh.io.npz import write_labels
from craftmesh.io.vtk import write_surface
from craftmesh.jit import is_kept
from craftmesh.report.shaded import draw  # a kernel of the last subcommand in LINES that compiles one
from craftmesh.surface.connectivity import compact
from craftmesh.surface.kernels import planar
from craftmesh.tetrahedra.surface_moves import given_way
from craftmesh.tetrahedra.whole_mesh import Model
from craftmesh.types import GrainTets, Surface, Voxels

CELLS = 6  # number of cells along the cube's edges
ALL, GRADATE, VOLUME = "all", "gradate", "volume"
SIZES = "--l-min 0.8 --l0 1 --l-max 2 --r0 2 --r1 4"
MODEL = "--microstructure labels.npz --quarter-points --material cubic:168400,121400,75400"
# Command lines from noisy voxels to a gradated surface, whose tetrahedra are poor enough to need
# optimisation.
VOXELS = (
    "generate --shape 14 14 14 --grains 3 --shuffled 0.3 -o generated.npz",
    "import generated.npz --labels labels.npz --image volume.vti --islands islands.json",
    "remesh labels.npz -o remeshed.vtp",
    "crack labels.npz --shape fronts --file front.csv -o crack.vtp",
    f"size remeshed.vtp --crack crack.vtp --labels labels.npz {SIZES} -o sizing.npz",
    "stitch remeshed.vtp --crack crack.vtp --sizing sizing.npz -o surface.vtp",
    "gradate surface.vtp --crack crack.vtp --sizing sizing.npz -o gradated.vtp",
)
# Command lines for crack and sizing of a cube, the smaller test model: its surface is made without kernels
# and gives few tetrahedra. A part of the kernels is compiled with it.
CUBE = (
    "crack gradated.vtp --shape through_edge --centre 0 3 3 --radius 3 -o crack.vtp",
    f"size gradated.vtp --crack crack.vtp {SIZES} -o sizing.npz",
)
GRADATED = ("gradate gradated.vtp --crack crack.vtp --sizing sizing.npz -o finer.vtp",)
# Command lines from the gradated surface, of the voxels or of the cube, to the growth of its crack.
SURFACE = (
    "tetrahedralize gradated.vtp --sizing sizing.npz --chunk 1/1 -o part.npz",
    "assemble gradated.vtp part.npz --sizing sizing.npz -o volume.vtu --front-csv front.csv",
    "check volume.vtu --labels labels.npz --quality quality.json",
    f"inp volume.vtu {MODEL} -o model.inp",
    f"solve volume.vtu {MODEL} -o solution.npz --vtu solution.vtu",
    f"fracture volume.vtu solution.npz {MODEL} --crack crack.vtp -o sif.csv",
    "depict volume.vtu -o pictures",
    "grow crack.vtp sif.csv front.csv --volume labels.npz -o grown.vtp",
)
LINES = {ALL: (*VOXELS, *SURFACE), GRADATE: (*CUBE, *GRADATED), VOLUME: (*CUBE, *SURFACE)}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "part",
        nargs="?",
        choices=tuple(LINES),
        default=ALL,
        help=f"{ALL} stages (default), only {GRADATE}, or the stages from tetrahedralize on ({VOLUME})",
    )


def run(arguments: argparse.Namespace) -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        labels, turns = np.ones((CELLS,) * 3, np.int32), np.tile([1.0, 0.0, 0.0, 0.0], (2, 1))
        write_labels(folder / "labels.npz", Voxels(labels, np.ones(3), np.zeros(3), turns))
        write_surface(folder / "gradated.vtp", cracked_cube())
        write_front(folder / "front.csv", {"points": saddle()})
        compile_patch()
        if arguments.part != GRADATE:
            compile_given_way()
        environment = {key: os.environ[key] for key in os.environ if key != "PYTHONDONTWRITEBYTECODE"}
        for line in LINES[arguments.part]:
            verb, *_ = words = line.split()
            print(verb, flush=True)
            command = [sys.executable, "-m", "craftmesh.cli", *words]
            done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
            if done.returncode:
                said = done.stderr.strip().splitlines() or [f"status {done.returncode}"]
                raise CraftmeshError(f"compile: craftmesh {verb} fails ({said[-1]}); report this")


@contextmanager
def compiling_ahead() -> Iterator[None]:
    """Compile in two other processes during this block, if nothing is compiled and there are two cores.

    The processes are ended at the end of the block; their errors are ignored.
    """
    # At normal priority: on a busy machine a stage would wait minutes for a kernel that these compile.
    words = [sys.executable, "-m", "craftmesh.cli", "compile"]
    alone = is_kept(draw) or len(os.sched_getaffinity(0)) == 1
    parts = () if alone else (GRADATE, VOLUME)
    with tempfile.TemporaryDirectory() as folder:
        env, quiet = os.environ | {"TMPDIR": folder}, subprocess.DEVNULL
        children = [
            subprocess.Popen([*words, part], env=env, stdout=quiet, stderr=quiet, start_new_session=True)
            for part in parts
        ]
        try:
            yield
        finally:
            for child in children:
                os.killpg(child.pid, signal.SIGTERM)  # and the subcommand that it runs
                child.wait()


def saddle() -> np.ndarray:
    """Return points (k, 3) of a closed front of a curved crack in the voxels; the last equals the first."""
    angle = np.append(np.linspace(0, 2 * np.pi, 4 * CELLS, endpoint=False), 0.0)
    return np.column_stack([7 + 4 * np.cos(angle), 7 + 4 * np.sin(angle), 7.2 + 1.2 * np.sin(2 * angle)])


def compile_patch() -> None:
    """Compile the kernels that insert points and edges inside a crack polygon, which LINES never call."""
    square = np.array([[0, 0], [4, 0], [4, 4], [0, 4], [1, 0.8], [3, 2.2], [2, 1]])
    segments = np.array([[0, 1], [1, 2], [2, 3], [3, 0], [4, 5]])
    patch = triangulate(square, segments, np.array([6]), lambda uv: np.ones(len(uv)))
    wall = np.isin(np.arange(len(square)), (0, 4))[:, None]
    planar.split_within_walls(with_room(patch, len(square)), wall, 2)


def compile_given_way() -> None:
    """Compile the kernels that move points at poor tetrahedra; the models of LINES may have none."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.3, 0.3, 1e-3]])
    facets = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    surface = Surface.of_facets(corners[:4], facets, (1, 0))
    tets = np.column_stack([facets[:, ::-1], np.full(4, 4)])
    given_way(Model(surface, [GrainTets(1, np.arange(4), corners[4:], tets)]))


def cracked_cube() -> Surface:
    """Return a cube of one grain with edge CELLS and a crack from its face x = 0 to its middle."""
    ends = [(axis, end) for axis in range(3) for end in (0, 1)]
    skin = [_plane(axis, end * CELLS, CELLS)[:, :: 1 if end else -1] for axis, end in ends]
    facets = np.concatenate([*skin, _plane(2, CELLS // 2, CELLS // 2)])
    is_crack = np.arange(len(facets)) >= sum(map(len, skin))
    places = np.stack(np.unravel_index(np.arange((CELLS + 1) ** 3), (CELLS + 1,) * 3), axis=1)
    points, corners, _ = compact(places.astype(float), facets)
    sides = np.column_stack([np.ones(len(facets), int), is_crack])
    return Surface.of_facets(points, corners, sides, is_crack)


def _plane(axis: int, height: int, width: int) -> np.ndarray:
    """Return facets (m, 3) of a plane perpendicular to an axis, with normals along the axis.

    height, width: the plane's coordinate on the axis, and its extent along the next axis, in cells. Corners
    are indices of the cube's grid points.
    """
    wide, long = np.meshgrid(np.arange(width), np.arange(CELLS), indexing="ij")
    cells = np.stack([wide.ravel(), long.ravel()], axis=1)

    def corner(ahead: int, aside: int) -> np.ndarray:
        place = np.full((len(cells), 3), height)
        place[:, [(axis + 1) % 3, (axis + 2) % 3]] = cells + [ahead, aside]
        return np.ravel_multi_index(tuple(place.T), (CELLS + 1,) * 3)

    a, b, c, d = corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])

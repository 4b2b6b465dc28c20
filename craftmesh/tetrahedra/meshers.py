"""The protocol of a tetrahedral mesher, the lookup by name, and TetGen as package and as program."""

import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Protocol

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.options import import_user_callable
from craftmesh.surface.rounding import EXACT

BUILT_IN = {
    "tetgen": "craftmesh.tetrahedra.meshers:TetGenMesher",
    "tetgen-cli": "craftmesh.tetrahedra.meshers:TetGenProgram",
}
# Not a mesher of single grains: `tetrahedra/whole/` meshes all grains at once with it.
TETWILD = "tetwild"


class MesherRefusal(Exception):
    """A mesher's own reason for not meshing a surface."""


class Mesher(Protocol):
    """A mesher of one closed surface that keeps the surface as it is."""

    def mesh(
        self,
        points: np.ndarray,
        facets: np.ndarray,
        markers: np.ndarray,
        interior_points: np.ndarray,
        holes: np.ndarray,
        switches: str,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return (points, tets) with the input points first, in order and bit for bit.

        points (n, 3); facets (m, 3): boundary and internal facets, all of which must be faces of tets;
        markers (m,): numbers > 0 of the facets; interior_points (k, 3): vertices that come after
        `points`; holes (h, 3): seeds in regions to leave empty; switches: in the mesher's own language.
        The tets (t, 4) int64 have positive volumes (corners 1, 2, 3 turn right-handed towards corner 4).
        Raises MesherRefusal if there is no such mesh.
        """
        ...


def load_mesher(name: str) -> Mesher:
    """Return the mesher called `name`: a built-in one, or an instance of `package.module:Class`.

    Raises CraftmeshError if there is none of this name, or if its class needs arguments.
    """
    made = import_user_callable("mesher", BUILT_IN.get(name, name), (*BUILT_IN, TETWILD))
    try:
        return made()
    except TypeError as error:
        raise CraftmeshError(f"mesher {name!r}: {error}; give a class without arguments") from error


def check_mesher(name: str) -> None:
    """Raise CraftmeshError unless `name` is a mesher with a method mesh.

    Built-in names are accepted without a look for their program or package.
    """
    if name not in (*BUILT_IN, TETWILD) and not callable(getattr(load_mesher(name), "mesh", None)):
        raise CraftmeshError(f"mesher {name!r} has no method mesh; add it as in tetrahedra.meshers.Mesher")


class TetGenMesher:
    """The package `tetgen` (AGPL-3.0), TetGen 1.6; it prints and may crash, so it belongs in a worker."""

    def mesh(
        self,
        points: np.ndarray,
        facets: np.ndarray,
        markers: np.ndarray,
        interior_points: np.ndarray,
        holes: np.ndarray,
        switches: str,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return points and tets as `Mesher` describes."""
        import tetgen

        everything = np.concatenate([points, interior_points]) if len(interior_points) else points
        try:
            plc = tetgen.TetGen(
                np.ascontiguousarray(everything, np.float64),
                np.ascontiguousarray(facets, np.int32),
                np.ascontiguousarray(markers, np.int32),
            )
            for seed in holes:
                plc.add_hole([float(x) for x in seed])
            nodes, tets, *_ = plc.tetrahedralize(switches=switches)
        except RuntimeError as error:
            raise MesherRefusal(str(error) or "TetGen failed") from error
        if not len(tets):
            raise MesherRefusal("TetGen made no tetrahedra")
        return np.asarray(nodes), np.asarray(tets, np.int64)


PROGRAM = "tetgen"


class TetGenProgram:
    """The program `tetgen` on the PATH, such as Debian's TetGen 1.5.

    Raises CraftmeshError if there is no such program.
    """

    def __init__(self) -> None:
        program = shutil.which(PROGRAM)
        if program is None:
            raise CraftmeshError(
                f"mesher tetgen-cli needs the program {PROGRAM!r} on the PATH; install it (Debian: apt-get "
                "install tetgen) or use mesher tetgen"
            )
        self.program = program

    def mesh(
        self,
        points: np.ndarray,
        facets: np.ndarray,
        markers: np.ndarray,
        interior_points: np.ndarray,
        holes: np.ndarray,
        switches: str,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Mesh as `Mesher` describes, in a temporary folder under the working folder."""
        everything = np.concatenate([points, interior_points]) if len(interior_points) else points
        with tempfile.TemporaryDirectory(dir=Path.cwd()) as folder:
            write_smesh(Path(folder) / "grain.smesh", everything, facets, markers, holes)
            done = subprocess.run(
                [self.program, f"-{switches}", "grain.smesh"], cwd=folder, capture_output=True, text=True
            )
            if done.returncode:
                raise MesherRefusal(_reason(done))
            try:
                nodes = _table(Path(folder) / "grain.1.node")[:, 1:4]
                tets = _table(Path(folder) / "grain.1.ele")[:, 1:5].astype(np.int64)
            except (FileNotFoundError, ValueError, IndexError) as error:
                raise MesherRefusal(f"TetGen left no mesh that can be read ({error})") from error
        if not len(tets):
            raise MesherRefusal("TetGen made no tetrahedra")
        return _with_exact(nodes, everything), tets


def write_smesh(
    path: Path, points: np.ndarray, facets: np.ndarray, markers: np.ndarray, holes: np.ndarray
) -> None:
    """Write TetGen's .smesh, numbered from 0, with coordinates that read back bit for bit."""
    with open(path, "w", encoding="ascii") as stream:
        stream.write(f"{len(points)} 3 0 0\n")
        stream.writelines(f"{i} {x!r} {y!r} {z!r}\n" for i, (x, y, z) in enumerate(points.tolist()))
        stream.write(f"{len(facets)} 1\n")
        rows = zip(facets.tolist(), markers.tolist())
        stream.writelines(f"3 {a} {b} {c} {marker}\n" for (a, b, c), marker in rows)
        stream.write(f"{len(holes)}\n")
        seeds = np.asarray(holes, float).reshape(-1, 3).tolist()
        stream.writelines(f"{i} {x!r} {y!r} {z!r}\n" for i, (x, y, z) in enumerate(seeds))


def _with_exact(nodes: np.ndarray, given: np.ndarray) -> np.ndarray:
    """Return nodes (n, 3) whose first rows are replaced by the given points (k, 3), bit for bit.

    nodes: as read from text. Raises MesherRefusal if given points are missing, or if a first row differs
    from its point by more than the fraction EXACT of the largest coordinate.
    """
    count = len(given)
    if len(nodes) < count:
        raise MesherRefusal(f"TetGen returned {len(nodes)} points, fewer than the {count} given")
    off = np.abs(nodes[:count] - given).max(initial=0.0)
    if not off <= EXACT * np.abs(given).max(initial=0.0):
        raise MesherRefusal(f"TetGen moved or renumbered points, by up to {off:.3g}")
    return np.concatenate([given, nodes[count:]])


def _table(path: Path) -> np.ndarray:
    """Return the rows of a TetGen file as an array, without header and comments."""
    return np.loadtxt(path, comments="#", skiprows=1, ndmin=2)


def _reason(done: subprocess.CompletedProcess) -> str:
    if done.returncode < 0:
        return f"TetGen ended by signal {-done.returncode}"
    lines = [line.strip() for line in (done.stderr + "\n" + done.stdout).splitlines() if line.strip()]
    told = [line for line in lines if "rror" in line or "ntersect" in line] or lines[-1:]
    return f"TetGen ended with status {done.returncode}" + (f": {told[0]}" if told else "")

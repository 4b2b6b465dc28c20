"""TetGen's command-line program behind the mesher's interface, through files in a temporary folder."""

import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.tetrahedra.meshers.base import MesherRefusal

PROGRAM = "tetgen"
# Largest difference between a coordinate and its text, as a share of the largest coordinate.
TEXT_PRECISION = 1e-12


class TetGenProgram:
    """The program `tetgen` on the PATH, such as Debian's TetGen 1.5; raises CraftmeshError without it."""

    def __init__(self) -> None:
        program = shutil.which(PROGRAM)
        if program is None:
            raise CraftmeshError(
                f"mesher tetgen-cli needs the program {PROGRAM!r} on the PATH; install it (Debian: apt-get "
                "install tetgen) or take mesher tetgen"
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
        """Mesh as `Mesher` promises, in a folder of its own under the working folder."""
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
    """Return the nodes with the `given` ones, which come first, as they were before they became text."""
    count = len(given)
    if len(nodes) < count:
        raise MesherRefusal(f"TetGen kept {len(nodes)} of {count} points")
    off = np.abs(nodes[:count] - given).max(initial=0.0)
    if not off <= TEXT_PRECISION * np.abs(given).max(initial=0.0):
        raise MesherRefusal(f"TetGen moved or renumbered points, by up to {off:.3g}")
    return np.concatenate([given, nodes[count:]])


def _table(path: Path) -> np.ndarray:
    """Return the rows of a file of TetGen without its head and comments."""
    return np.loadtxt(path, comments="#", skiprows=1, ndmin=2)


def _reason(done: subprocess.CompletedProcess) -> str:
    if done.returncode < 0:
        return f"TetGen ended by signal {-done.returncode}"
    lines = [line.strip() for line in (done.stderr + "\n" + done.stdout).splitlines() if line.strip()]
    told = [line for line in lines if "rror" in line or "ntersect" in line] or lines[-1:]
    return f"TetGen ended with status {done.returncode}" + (f": {told[0]}" if told else "")

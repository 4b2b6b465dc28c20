"""Where a grain's surface fails: the facets at fault, and their neighbourhood to look at."""

import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.tetrahedra.grain_surface import GrainSurface

# Where TetGen lists the facets it could not use, in its working folder.
SKIPPED = "tetgen-tmpfile_skipped.face"
# Seconds for TetGen's own diagnosis.
TIME_LIMIT = 120.0
_ASK = (
    "import sys, numpy, tetgen; data = numpy.load(sys.argv[1]); facets = data['facets'];"
    "ids = numpy.arange(1, len(facets) + 1, dtype=numpy.int32);"
    "tetgen.TetGen(data['points'], facets.astype(numpy.int32), ids).tetrahedralize(switches='pYQ')"
)


@dataclass(frozen=True)
class GrainFailure:
    """A grain that could not be meshed.

    reason: the last attempt's; attempts: what was tried and how it ended; facet_ids: rows of the Surface
    at fault (may be empty); surface: the grain's own surface, with `at_fault` (m,) marking its facets.
    """

    grain: int
    reason: str
    attempts: tuple
    facet_ids: np.ndarray
    surface: GrainSurface
    at_fault: np.ndarray

    @property
    def place(self) -> np.ndarray | None:
        """Mean coordinates (3,) of the facets at fault, if any."""
        if not self.at_fault.any():
            return None
        return self.surface.points[self.surface.facets[self.at_fault]].mean((0, 1))

    @property
    def marks(self) -> dict[str, np.ndarray]:
        """Marks (m,) of the facets of `surface`, to look at: at fault, crack, row of the Surface."""
        return {
            "at_fault": self.at_fault,
            "crack": self.surface.internal,
            "facet": self.surface.facet_ids,
        }

    def report(self) -> dict:
        """Return the failure as reports list it."""
        return {
            "reason": self.reason,
            "facets": self.facet_ids.tolist(),
            "attempts": list(self.attempts),
        }

    def sentence(self) -> str:
        """Return the failure in one line."""
        text = f"grain {self.grain} could not be meshed in {len(self.attempts)} attempts: {self.reason}"
        if self.place is None:
            return text
        near = ", ".join(f"{x:.6g}" for x in self.place)
        return f"{text}; facets {shortened(self.facet_ids)} near ({near})"


def diagnose(surface: GrainSurface, attempts: tuple, where: np.ndarray, ask_tetgen: bool) -> GrainFailure:
    """Return the failure of a grain with the facets at fault.

    These are the facets that intersect; failing that those that TetGen's own diagnosis names; failing
    that `where`, rows of the grain's facets that the checks found.
    """
    rows = np.unique(intersecting_pairs(surface.points, surface.facets))
    if not len(rows) and ask_tetgen:
        rows = tetgen_diagnosis(surface)
    if not len(rows):
        rows = np.asarray(where, np.int64)
    at_fault = np.zeros(len(surface.facets), bool)
    at_fault[rows] = True
    return GrainFailure(
        surface.grain, attempts[-1]["reason"], attempts, surface.facet_ids[at_fault], surface, at_fault
    )


def tetgen_diagnosis(surface: GrainSurface) -> np.ndarray:
    """Return rows of the grain's facets that TetGen skips, run apart in a temporary folder."""
    with tempfile.TemporaryDirectory() as folder:
        data = Path(folder) / "surface.npz"
        np.savez(data, points=surface.points, facets=surface.facets)
        try:
            command = [sys.executable, "-c", _ASK, str(data)]
            subprocess.run(command, cwd=folder, capture_output=True, timeout=TIME_LIMIT)
            lines = (Path(folder) / SKIPPED).read_text().splitlines()[1:]
        except (subprocess.TimeoutExpired, FileNotFoundError):
            return np.zeros(0, np.int64)
    # a line is: number, three corners, marker; markers are rows of the facets + 1
    named = [int(line.split()[4]) - 1 for line in lines if line.strip() and line[0] != "#"]
    rows = np.unique(np.array(named, np.int64))
    return rows[(rows >= 0) & (rows < len(surface.facets))]


def shortened(ids: Sequence[int] | np.ndarray, limit: int = 6) -> str:
    """Return the first ids as text and how many more there are."""
    text = ", ".join(str(i) for i in ids[:limit])
    return text if len(ids) <= limit else f"{text} and {len(ids) - limit} more"

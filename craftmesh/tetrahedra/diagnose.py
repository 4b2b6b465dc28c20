"""Diagnosis of a grain that cannot be meshed: the faulty facets of its surface."""

import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.tetrahedra.grain_surface import GrainSurface

# File in TetGen's working folder that lists the facets it could not use.
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

    reason: error of the last attempt; attempts: dicts of all attempts (`Attempt.report`); facet_ids: faulty
    facets as rows of the Surface (may be empty); surface: the grain's own surface; at_fault (m,): mask of
    the faulty facets among the grain's facets.
    """

    grain: int
    reason: str
    attempts: tuple
    facet_ids: np.ndarray
    surface: GrainSurface
    at_fault: np.ndarray

    @property
    def place(self) -> np.ndarray | None:
        """Mean coordinates (3,) of the faulty facets, None if there are none."""
        if not self.at_fault.any():
            return None
        return self.surface.points[self.surface.facets[self.at_fault]].mean((0, 1))

    @property
    def marks(self) -> dict[str, np.ndarray]:
        """Arrays (m,) for a picture of `surface`, by name.

        at_fault: mask of faulty facets; crack: mask of facets inside the grain; facet: rows of the Surface.
        """
        return {
            "at_fault": self.at_fault,
            "crack": self.surface.internal,
            "facet": self.surface.facet_ids,
        }

    def report(self) -> dict:
        """Return the failure as a dict for JSON: reason, facets (rows of the Surface) and attempts."""
        return {
            "reason": self.reason,
            "facets": self.facet_ids.tolist(),
            "attempts": list(self.attempts),
        }

    def sentence(self) -> str:
        """Return grain, number of attempts and last reason in one line, and the faulty facets, if known."""
        text = f"grain {self.grain} could not be meshed in {len(self.attempts)} attempts: {self.reason}"
        if self.place is None:
            return text
        near = ", ".join(f"{x:.6g}" for x in self.place)
        return f"{text}; facets {shortened(self.facet_ids)} near ({near})"


def diagnose(surface: GrainSurface, attempts: tuple, where: np.ndarray, ask_tetgen: bool) -> GrainFailure:
    """Return the failure of a grain with its faulty facets.

    Faulty facets are the facets that intersect. If none do and `ask_tetgen` is true, they are the facets
    that TetGen's own diagnosis names. If there are still none, they are `where`, the rows of the grain's
    facets that the last failed check found. attempts: reports of all attempts, at least one.
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
    """Return rows of the grain's facets that TetGen skips, from a TetGen process in a temporary folder.

    The result is empty if the process takes longer than TIME_LIMIT or leaves no list of skipped facets.
    """
    with tempfile.TemporaryDirectory() as folder:
        data = Path(folder) / "surface.npz"
        np.savez(data, points=surface.points, facets=surface.facets)
        try:
            command = [sys.executable, "-c", _ASK, str(data)]
            subprocess.run(command, cwd=folder, capture_output=True, timeout=TIME_LIMIT)
            lines = (Path(folder) / SKIPPED).read_text().splitlines()[1:]
        except (subprocess.TimeoutExpired, FileNotFoundError):
            return np.zeros(0, np.int64)
    # a line has number, three corners and marker; a facet's marker is its row plus one (_ASK sets them)
    named = [int(line.split()[4]) - 1 for line in lines if line.strip() and line[0] != "#"]
    rows = np.unique(np.array(named, np.int64))
    return rows[(rows >= 0) & (rows < len(surface.facets))]


def shortened(ids: Sequence[int] | np.ndarray, limit: int = 6) -> str:
    """Return the first `limit` ids as text "1, 2", followed by "and 3 more" if there are further ids."""
    text = ", ".join(str(i) for i in ids[:limit])
    return text if len(ids) <= limit else f"{text} and {len(ids) - limit} more"

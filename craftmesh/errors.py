"""The one family of errors that craftmesh raises on purpose, and how messages write numbers and names."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import os

    import numpy as np

INTERRUPTED = 130  # the status of what a signal ends, in shells


class CraftmeshError(Exception):
    """An input or a state that craftmesh refuses, said in one line that names what to do.

    The message names the key, file or grain, the value found, what is expected and what to do.
    The command line prints it as it is and exits with status 1.
    """


class MeshingError(CraftmeshError):
    """Grains that no attempt could mesh.

    `failures`: one GrainFailure (craftmesh.tetrahedra.diagnose) per grain that failed; `done`: GrainTets of
    all others; `report`: the stage's report with every attempt.
    """

    def __init__(self, message: str, failures: tuple = (), done: tuple = (), report: dict | None = None):
        super().__init__(message)
        self.failures = failures
        self.done = done
        self.report = report or {}


@contextmanager
def named(place: object) -> Iterator[None]:
    """Begin the message of a CraftmeshError that is raised within with a place: a file, a row or a key."""
    try:
        yield
    except CraftmeshError as error:
        raise CraftmeshError(f"{place}: {error}") from None


def existing(path: "str | os.PathLike", advice: str = "check the path") -> Path:
    """Return the path of a file or a folder; raises CraftmeshError, with what to do, where it is neither.

    A FIFO would stop its reader, a device may have no end.
    """
    path = Path(path)
    if not path.exists():
        raise CraftmeshError(f"{path}: no such file; {advice}")
    if not (path.is_file() or path.is_dir()):
        raise CraftmeshError(
            f"{path}: is no regular file but a FIFO, a socket or a device; copy its data into a file"
        )
    return path


def existing_file(path: "str | os.PathLike", advice: str = "check the path") -> Path:
    """Return the path of a file; errors as `existing`, and for a folder."""
    file = existing(path, advice)
    if file.is_dir():
        raise CraftmeshError(f"{path}: is a folder; {advice}")
    return file


def told(places: "np.ndarray") -> list:
    """Return an array of any shape as lists of numbers with six digits, enough to find a place again."""
    import numpy as np  # not for `craftmesh --help`

    return np.reshape([float(f"{x:.6g}") for x in np.ravel(places)], np.shape(places)).tolist()


def listed(names: Iterable) -> str:
    """Return names for an error message, the first two dozen where there are more: a section's keys fit."""
    names = list(names)
    more = f" and {len(names) - 24} more" if len(names) > 24 else ""
    return (", ".join(map(str, names[:24])) or "none") + more


def counted(voxels: int, total: int) -> str:
    """Return a number of voxels and their share of the volume, in words."""
    return f"{voxels} voxels ({100 * voxels / total:.2g} %)"

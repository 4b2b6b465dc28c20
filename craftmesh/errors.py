"""CraftmeshError, the base of all errors that craftmesh raises on purpose, and formats for messages."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import os

    import numpy as np

INTERRUPTED = 130  # exit status after a signal; shells report 128 + SIGINT after Ctrl-C


class CraftmeshError(Exception):
    """An invalid input or state, described in one line that says what to do.

    The message names the key, file or grain, the value found, what is expected and what to do. The command
    line prints the message unchanged and exits with status 1.
    """


class MeshingError(CraftmeshError):
    """No meshing attempt succeeded for some grains.

    `failures`: one GrainFailure (craftmesh.tetrahedra.diagnose) per failed grain; `done`: GrainTets of all
    other grains; `report`: the stage's report with every attempt.
    """

    def __init__(self, message: str, failures: tuple = (), done: tuple = (), report: dict | None = None):
        super().__init__(message)
        self.failures = failures
        self.done = done
        self.report = report or {}


@contextmanager
def named(place: object) -> Iterator[None]:
    """Prefix `place` (file, row or key) to the message of a CraftmeshError raised in the `with` block."""
    try:
        yield
    except CraftmeshError as error:
        raise CraftmeshError(f"{place}: {error}") from None


def existing(path: "str | os.PathLike", advice: str = "check the path") -> Path:
    """Return `path` as a Path; raise CraftmeshError unless it is a regular file or a folder.

    advice: what to do if the path does not exist. FIFOs and devices are rejected: a FIFO would block its
    reader, and a device may have no end.
    """
    path = Path(path)
    if not path.exists():
        raise CraftmeshError(f"{path}: no such file; {advice}")
    if not (path.is_file() or path.is_dir()):
        raise CraftmeshError(
            f"{path}: not a regular file but a FIFO, socket or device; copy its data into a file"
        )
    return path


def existing_file(path: "str | os.PathLike", advice: str = "check the path") -> Path:
    """Return `path` as a Path; raise CraftmeshError as `existing` does, and for a folder."""
    file = existing(path, advice)
    if file.is_dir():
        raise CraftmeshError(f"{path}: is a folder; {advice}")
    return file


def rounded_values(places: "np.ndarray") -> list:
    """Return an array of any shape as nested lists of its numbers, rounded to six significant digits."""
    import numpy as np  # imported here, because `craftmesh --help` needs no numpy

    return np.reshape([float(f"{x:.6g}") for x in np.ravel(places)], np.shape(places)).tolist()


def listed(names: Iterable) -> str:
    """Return names joined for an error: at most 24, enough for a section's keys, and how many more."""
    names = list(names)
    more = f" and {len(names) - 24} more" if len(names) > 24 else ""
    return (", ".join(map(str, names[:24])) or "none") + more


def counted(voxels: int, total: int) -> str:
    """Return a number of voxels and its percentage of `total` as a text."""
    return f"{voxels} voxels ({100 * voxels / total:.2g} %)"

"""A volume in a .npy file: labels only, so the axis order and the spacing have to be given."""

import os

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io.file_volume import FileVolume, to_xyz


def read(path: str | os.PathLike, axes: str) -> FileVolume:
    """Read a .npy whose axes are in the order `axes` ("xyz", "zyx", ...); raises CraftmeshError."""
    if not axes:
        raise CraftmeshError(f"{path}: a .npy does not say its axis order; give axes as xyz or zyx")
    try:
        labels = np.load(path, allow_pickle=False)
    except (ValueError, OSError, EOFError) as error:
        raise CraftmeshError(f"{path}: is not a .npy of numbers ({error}); write it anew") from None
    if not isinstance(labels, np.ndarray):
        labels.close()
        raise CraftmeshError(f"{path}: is an .npz archive; name it so or give format npz")
    return FileVolume(to_xyz(labels, axes, str(path)))

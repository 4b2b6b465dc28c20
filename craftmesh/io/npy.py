"""A volume in a .npy file: labels only, so the axis order and the spacing have to be given."""

import os
import zipfile

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io.file_volume import FileVolume, to_xyz
from craftmesh.io.npz import BROKEN, refuse_false_head


def read(path: str | os.PathLike, axes: str) -> FileVolume:
    """Read a .npy whose axes are in the order `axes` ("xyz", "zyx", ...); raises CraftmeshError."""
    if not axes:
        raise CraftmeshError(f"{path}: a .npy does not say its axis order; give axes as xyz or zyx")
    if zipfile.is_zipfile(path):
        raise CraftmeshError(f"{path}: is an .npz archive; name it so or give format npz")
    try:
        with open(path, "rb") as stream:
            refuse_false_head(path, "its array", stream, os.path.getsize(path))
        labels = np.load(path, allow_pickle=False)
    except BROKEN as error:
        raise CraftmeshError(f"{path}: is not a .npy of numbers ({error}); write it anew") from None
    return FileVolume(to_xyz(labels, axes, str(path)))

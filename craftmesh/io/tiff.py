"""TIFF stacks: one multi-page file, or a folder of slices; pages are z, rows y, columns x."""

import os
import re
from pathlib import Path

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io.file_volume import FileVolume

SUFFIXES = (".tif", ".tiff")


def read(path: str | os.PathLike) -> FileVolume:
    """Read a stack of integer slices; a folder's slices go by the numbers in their names.

    A TIFF has no spacing that could be relied on: the caller gives it. Raises CraftmeshError.
    """
    path = Path(path)
    if path.is_dir():
        slices = [_pages(file) for file in slice_files(path)]
        _check_slices(path, slices)
        volume = np.stack(slices)
    else:
        volume = _pages(path)
    if volume.ndim != 3:
        raise CraftmeshError(
            f"{path}: pages have shape {volume.shape}; expected a stack of grey slices (z, y, x)"
        )
    notes: tuple[str, ...] = ()
    if volume.dtype == np.uint8 and volume.max(initial=0) == 255:
        notes = (
            "8-bit labels that reach 255: more grains than 255 would have been cut off; export 16 bits",
        )
    return FileVolume(volume.transpose(2, 1, 0), notes=notes)


def slice_files(folder: Path) -> list[Path]:
    """Return the .tif files of a folder, ordered by the numbers in their names (slice2 before slice10)."""

    def key(file: Path) -> list:
        return [
            (0, int(part), "") if part.isdigit() else (1, 0, part) for part in re.split(r"(\d+)", file.name)
        ]

    return sorted((file for file in folder.iterdir() if file.suffix.lower() in SUFFIXES), key=key)


def _pages(file: Path) -> np.ndarray:
    import tifffile

    try:
        return tifffile.imread(file)
    except Exception as error:  # tifffile and its codecs raise many kinds
        reason = " ".join(str(error).split())
        raise CraftmeshError(f"{file}: cannot be read as TIFF ({reason}); export it uncompressed") from None


def _check_slices(folder: Path, slices: list[np.ndarray]) -> None:
    if not slices:
        raise CraftmeshError(
            f"{folder}: has no .tif slices; give a folder of slices, or run craftmesh stitch on STL files"
        )
    shapes = sorted({(s.shape, str(s.dtype)) for s in slices})
    if len(shapes) > 1:
        raise CraftmeshError(
            f"{folder}: slices differ: {shapes[0]} and {shapes[1]}; expected one shape and type"
        )

"""Further files that a reader opens: the data file of a header, image slices, parts of a surface."""

from pathlib import Path

from craftmesh.io.metaimage_nrrd import metaimage_data, nrrd_data
from craftmesh.io.surface_files import parts_beside
from craftmesh.io.tesr import tesr_data
from craftmesh.io.tiff import slice_files
from craftmesh.io.volume_format import AUTO, format_of_suffix

_FINDERS = {"metaimage": metaimage_data, "nrrd": nrrd_data, "tesr": tesr_data}


def files_behind(path: Path, kind: str = AUTO) -> list[Path]:
    """Return the files that the reader of `path` opens in addition, in order; for a folder, its slices.

    kind: the file's format, a key of SUFFIXES; AUTO: by its name. Raises CraftmeshError, as the reader
    does, for missing files and for folders without an image stack.
    """
    if path.is_dir():
        return slice_files(path)
    return _FINDERS.get(format_of_suffix(path) if kind == AUTO else kind, parts_beside)(path)

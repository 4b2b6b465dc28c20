"""Triangulated surfaces in other tools' files: STL, PLY, OBJ, OFF and 3MF, ASCII and binary, by trimesh.

Other formats that trimesh reads (glTF, COLLADA, formats of meshio, ...) are read too. trimesh is imported
on first use. Its clean-up is off: points are neither joined nor moved.
"""

import json
import os
import re
import warnings
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from craftmesh.arguments import as_array
from craftmesh.errors import CraftmeshError, existing_file
from craftmesh.extras import extra
from craftmesh.io.header_checks import HEAD, data_file, enough_memory, heard, refuse_false_zip

SUFFIXES = (".stl", ".ply", ".obj", ".off", ".3mf")
LISTED = f"{', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}"  # for messages
_GRAIN = re.compile(r"(\d+)$")
_TEXT_CUT_SHORT = "string or file could not be read to its end"  # numpy's warning at text that is no number
# Number of faces in a file's header. It is compared because trimesh reads truncated files without an error.
_FACE_COUNT = {
    ".ply": re.compile(rb"^element\s+face\s+(\d+)", re.M),
    ".off": re.compile(rb"OFF(?:\s|#.*)*\d+\s+(\d+)"),
}
_STL_HEAD = np.dtype([("title", "S80"), ("count", "<u4")])
_STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("colour", "<u2")])
_NO_SURFACES = {"bz2", "zip", "xdmf", "xmf"}  # archives, and headers whose data are in other files


def read_triangles(path: str | os.PathLike) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 3) float64 and triangles (m, 3) int64 of a surface file; its suffix is its format.

    Points are in the file's order, without points of no triangle. In an STL every triangle has three points
    of its own. Coordinates have the file's precision: float32 in binary STL, float64 in text. Several
    bodies follow one after the other; polygons are split into triangles. Raises CraftmeshError for a
    missing, damaged, truncated or unknown file, one without triangles, and coordinates that are not finite.
    """
    path = Path(path)
    points, triangles = _joined(path, _parts(path))
    return points.astype(float), triangles


def _joined(path: Path, parts: list[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """Return the points (n, 3) and triangles (m, 3) of the bodies of a file as one surface."""
    if not parts:
        raise CraftmeshError(f"{path}: contains no triangles; give a triangulated surface")
    shifts = np.cumsum([0, *(len(points) for points, _ in parts)])
    _refuse_cut_short(path, sum(len(triangles) for _, triangles in parts))
    points = np.concatenate([points for points, _ in parts])
    triangles = np.concatenate([triangles + shift for (_, triangles), shift in zip(parts, shifts)])
    as_array(f"{path}: points", points, float, (None, 3))
    return points, triangles


def read_grain_folder(folder: str | os.PathLike) -> list[tuple[int, np.ndarray, np.ndarray]]:
    """Return (grain id, points (n, 3), triangles (m, 3)) of each surface file `*<id>` in a folder, by id.

    Points of binary STL files are float32, as in the files. Hidden files, files with other suffixes, and
    files whose names do not end with a number (`unnumbered`) are ignored. Raises CraftmeshError for a
    folder without such files or with several formats, a duplicate id, several solids in a file, and a
    damaged file.
    """
    found: dict[int, Path] = {}
    for path in _surfaces_in(folder):
        number = _GRAIN.search(path.stem)
        if not number:
            continue
        grain = int(number.group())
        if grain in found:
            raise CraftmeshError(
                f"{path}: grain {grain} is also in {found[grain].name}; keep one file per grain"
            )
        found[grain] = path
    if not found:
        raise CraftmeshError(
            f"{folder}: no file named *<grain id> with suffix {LISTED}; put one such file per grain there"
        )
    (first, a), *others = {path.suffix.lower(): path.name for path in found.values()}.items()
    for second, b in others:
        raise CraftmeshError(
            f"{folder}: contains {first} and {second} files ({a}, {b}); keep the files of one format"
        )
    surfaces = []
    for grain, path in sorted(found.items()):
        parts = _parts(path)
        solids = _objects(path) if path.suffix.lower() == ".obj" else len(parts)
        if solids > 1:
            raise CraftmeshError(
                f"{path}: contains {solids} solids; expected one grain per file, write each solid to a "
                "file of its own, named *<grain id>"
            )
        surfaces.append((grain, *_joined(path, parts)))
    return surfaces


def unnumbered(folder: str | os.PathLike) -> list[str]:
    """Return the names of the surface files in a folder that do not end with a number, a grain's id.

    `read_grain_folder` ignores these files.
    """
    return [path.name for path in _surfaces_in(folder) if not _GRAIN.search(path.stem)]


def _surfaces_in(folder: str | os.PathLike) -> list[Path]:
    paths = sorted(Path(folder).iterdir())
    return [path for path in paths if path.suffix.lower() in SUFFIXES and not path.name.startswith(".")]


def _objects(path: Path) -> int:
    """Return the number of objects with faces in an OBJ, or of groups with faces if no object has any.

    They are counted here because trimesh joins them into one body.
    """
    _, *marked = re.split(rb"^[ \t]*([og])[ \t]+([^\r\n]*)", path.read_bytes(), flags=re.M)
    named: dict[bytes, set[bytes | int]] = {b"o": set(), b"g": set()}
    latest: dict[bytes, bytes | int] = {}
    for row, (kind, name, text) in enumerate(zip(marked[::3], marked[1::3], marked[2::3])):
        latest[kind] = name.strip() if kind == b"g" else row  # a group's name may occur again later
        if re.search(rb"^[ \t]*f[ \t]", text, re.M):
            for each, of in latest.items():
                named[each].add(of)
    return len(named[b"o"] or named[b"g"])


def vertices_of(path: str | os.PathLike) -> np.ndarray:
    """Return the points (n, 3) of a surface or point cloud that trimesh reads, in the file's order.

    Shape (0, 3) if the file has none. Raises CraftmeshError for unknown suffixes and damaged files.
    """
    with extra("formats"):
        import trimesh

    scene = _scene(Path(path))
    parts = [body for body in scene.dump() if isinstance(body, (trimesh.Trimesh, trimesh.PointCloud))]
    return np.concatenate([np.zeros((0, 3)), *(np.asarray(body.vertices, float) for body in parts)])


def _parts(path: Path) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return (points, triangles) of each body with triangles, at its position in the file's scene."""
    path = existing_file(path, f"give a triangulated surface ({LISTED})")
    if path.suffix.lower() == ".stl" and len(corners := _binary_stl(path)):
        return [(corners, np.arange(len(corners)).reshape(-1, 3))]
    scene = _scene(path)
    flat = path.suffix.lower() in SUFFIXES[:-1]  # scenes of other formats may move and repeat bodies
    bodies = list(scene.geometry.values()) if flat else scene.dump()
    meshes = [body for body in bodies if len(getattr(body, "faces", ()))]
    parts = [(np.asarray(mesh.vertices, float), np.asarray(mesh.faces, np.int64)) for mesh in meshes]
    for points, triangles in parts:
        if triangles.min() < 0 or triangles.max() >= len(points):
            raise CraftmeshError(
                f"{path}: triangles have points up to {triangles.max()} of {len(points)}; write it again"
            )
    return [_used(*part) for part in parts]


def _binary_stl(path: Path) -> np.ndarray:
    """Return the corners (3m, 3) float32 of a binary STL's m triangles.

    Shape (0, 3) if the file's size is not that for the number of triangles in its header.
    """
    head = np.fromfile(path, _STL_HEAD, 1)
    due = head["count"].astype(np.int64) * _STL_TRIANGLE.itemsize + _STL_HEAD.itemsize
    if path.stat().st_size not in due:
        return np.zeros((0, 3), np.float32)
    return np.fromfile(path, _STL_TRIANGLE, offset=_STL_HEAD.itemsize)["corners"].reshape(-1, 3)


def _scene(path: Path) -> Any:
    """Return the trimesh object that trimesh reads from a file, without its clean-up."""
    with extra("formats"):
        import trimesh

    suffix = path.suffix.lower()
    if suffix[1:] not in trimesh.available_formats() - _NO_SURFACES:
        raise CraftmeshError(
            f"{path}: suffix {path.suffix!r} is not known; expected {LISTED}, or another format "
            "that trimesh reads"
        )
    # Textures and materials would make trimesh look for more files, and split points that differ in them.
    plain: dict[str, Any] = {
        "process": False,
        "maintain_order": True,
        "skip_materials": True,
        "fix_texture": False,
    }
    try:
        _refuse_false_containers(path)
        with warnings.catch_warnings(), enough_memory(path), heard("trimesh"), open(path, "rb") as stream:
            warnings.filterwarnings("error", _TEXT_CUT_SHORT, DeprecationWarning)
            beside: Any = _Beside(path)
            return trimesh.load_scene(stream, file_type=suffix[1:], resolver=beside, **plain)
    except CraftmeshError:
        raise
    except Exception as error:  # trimesh's readers raise many types
        raise CraftmeshError(
            f"{path}: is not a complete {suffix[1:].upper()} file ({type(error).__name__}: {error}); "
            "write it again"
        ) from None


class _Beside:
    """Gives trimesh the further files that a surface file names; they must be in its folder or below."""

    def __init__(self, path: Path):
        self.path = path

    def path_of(self, name: str) -> Path:
        return data_file(self.path, "its part", name)

    def get(self, name: str) -> bytes:
        return self.path_of(name).read_bytes()

    __getitem__ = get


def parts_beside(path: Path) -> list[Path]:
    """Return the files that contain the numbers of a glTF, [] for other surface files.

    Raises CraftmeshError for a damaged glTF, and if one of the files is missing.
    """
    suffix = path.suffix.lower()
    if suffix not in (".gltf", ".glb"):
        return []
    content = path.read_bytes()
    if suffix == ".glb":  # its header has 12 bytes; length and kind of the first chunk have 4 each
        content = content[20 : 20 + int.from_bytes(content[12:16], "little")]
    try:
        names = [buffer.get("uri", "data:") for buffer in json.loads(content).get("buffers", [])]
    except (ValueError, AttributeError, TypeError) as error:
        raise CraftmeshError(f"{path}: is not a complete glTF file ({error}); write it again") from None
    return [_Beside(path).path_of(name) for name in names if not name.startswith("data:")]


def _refuse_false_containers(path: Path) -> None:
    """Raise CraftmeshError for a zip archive or HDF5 file that declares more than it or memory can hold.

    Also raises for HDF5 files with data in other files. Files of other kinds are not checked.
    """
    from craftmesh.io.hdf5 import h5py, opened  # here because the import of h5py is slow

    if zipfile.is_zipfile(path):
        refuse_false_zip(path)
    if h5py.is_hdf5(path):
        with opened(path):
            pass


def _refuse_cut_short(path: Path, triangles: int) -> None:
    pattern = _FACE_COUNT.get(path.suffix.lower())
    if pattern is None:
        return
    with open(path, "rb") as stream:
        named = pattern.search(stream.read(HEAD))
    if named and triangles < int(named.group(1)):
        raise CraftmeshError(
            f"{path}: contains {triangles} triangles, but its header has {named.group(1).decode()} faces; "
            "the file is truncated, copy it or write it again"
        )


def _used(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the points that are corners of triangles, in order, and the triangles (m, 3) renumbered."""
    used = np.zeros(len(points), bool)
    used[triangles] = True
    if used.all():
        return points, triangles
    return points[used], (np.cumsum(used) - 1)[triangles]

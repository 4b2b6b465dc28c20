"""Folders of STL files, one closed surface per grain; the grain's id ends the file's name."""

import os
import re
from pathlib import Path

import numpy as np

from craftmesh.atomic import atomic_path
from craftmesh.errors import CraftmeshError
from craftmesh.surface.connectivity import compact
from craftmesh.types import Surface

_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_VERTEX = re.compile(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)")
_NAME = re.compile(r"(\d+)\.stl$", re.IGNORECASE)


def read_stl_folder(folder: str | os.PathLike) -> list[tuple[int, np.ndarray, np.ndarray]]:
    """Return (grain id, points (n, 3), triangles (m, 3)) of every `*<id>.stl` in a folder, by id.

    Raises CraftmeshError for a folder without such files, an id met twice, or a broken file.
    """
    found: dict[int, Path] = {}
    for path in sorted(Path(folder).iterdir()):
        match = _NAME.search(path.name)
        if not match:
            continue
        grain = int(match.group(1))
        if grain in found:
            raise CraftmeshError(
                f"{path}: grain {grain} is in {found[grain].name} too; expected one file a grain"
            )
        found[grain] = path
    if not found:
        raise CraftmeshError(f"{folder}: no file named *_<grain id>.stl; expected one STL file per grain")
    return [(grain, *read_stl(found[grain])) for grain in sorted(found)]


def read_stl(path: str | os.PathLike) -> tuple[np.ndarray, np.ndarray]:
    """Return points (3 m, 3) and triangles (m, 3) of a binary or ASCII STL; corners are not joined."""
    data = Path(path).read_bytes()
    count = int.from_bytes(data[80:84], "little")
    if len(data) >= 84 and len(data) == 84 + _RECORD.itemsize * count:
        corners = np.frombuffer(data, _RECORD, count, 84)["corners"].astype(float).reshape(-1, 3)
    elif data.lstrip()[:5].lower() == b"solid":
        try:
            corners = np.array(_VERTEX.findall(data), dtype="S32").astype(float).reshape(-1, 3)
        except ValueError as error:
            raise CraftmeshError(f"{path}: {error}; expected three numbers after `vertex`") from None
    else:
        raise CraftmeshError(
            f"{path}: {len(data)} bytes for {count} triangles; expected a binary or ASCII STL file"
        )
    if not len(corners) or len(corners) % 3 or not np.isfinite(corners).all():
        raise CraftmeshError(f"{path}: {len(corners)} corners; expected finite corners, three a triangle")
    return corners, np.arange(len(corners)).reshape(-1, 3)


def write_stl(path: str | os.PathLike, points: np.ndarray, triangles: np.ndarray) -> None:
    """Write a binary STL (float32 coordinates)."""
    records = np.zeros(len(triangles), _RECORD)
    corners = points[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    records["normal"] = normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    records["corners"] = corners
    with atomic_path(path) as temporary:
        Path(temporary).write_bytes(bytes(80) + len(records).to_bytes(4, "little") + records.tobytes())


def write_stl_folder(folder: str | os.PathLike, surface: Surface, prefix: str = "grain") -> list[Path]:
    """Write `<prefix>_<id>.stl` per grain, normals outward, crack facets inside a grain left out."""
    Path(folder).mkdir(parents=True, exist_ok=True)
    paths = []
    for grain in surface.grains.tolist():
        behind, ahead = (surface.sides == grain).T
        facets = np.concatenate([surface.facets[behind & ~ahead], surface.facets[ahead & ~behind][:, ::-1]])
        points, facets, _ = compact(surface.points, facets)
        paths.append(Path(folder) / f"{prefix}_{grain}.stl")
        write_stl(paths[-1], points, facets)
    return paths

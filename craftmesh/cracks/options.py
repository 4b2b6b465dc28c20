"""Options of the crack: its shape, its growth, and the files that describe it."""

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Literal

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.options import Options, option

BY_NUMBERS = ("penny", "ellipse", "through_edge")
BY_FILES = {
    "surface": "triangles in .vtp, .stl, .ply, .obj, .off, .3mf or another format that trimesh reads",
    "points": "measured points in .csv, .xyz, .vtp, .ply or the like",
    "fronts": "the front in .csv",
    "path": "the columns x and y of a path measured in a plane in .csv",
    "voxels": "labels in .npz, .npy, .vti, .dream3d or .tif",
}
IN_BOUNDARIES, SLIP_PLANE = "boundaries", "slip_plane"
OF_GRAINS = (IN_BOUNDARIES, SLIP_PLANE)  # shapes made from the surfaces of grains
Shape = Literal[
    "penny",
    "ellipse",
    "through_edge",
    "surface",
    "points",
    "fronts",
    "path",
    "voxels",
    "boundaries",
    "slip_plane",
]
_PLANE, _SERIES = ("centre", "normal", "axis"), ("growth", "increments")
# Keys that each shape uses; any other key is rejected, because it would have no effect.
TAKEN = {
    "penny": (*_PLANE, "radius", *_SERIES),
    "ellipse": (*_PLANE, "semi_axes", *_SERIES),
    "through_edge": (*_PLANE, "radius", *_SERIES),
    "surface": ("file", "front", "increments"),
    "points": ("file", "front", "spacing", "increments"),
    "fronts": ("file", "spacing", "inside", "increments"),
    "path": ("file", *_PLANE, "radius", "scale", "start", "slant", "growth"),
    "voxels": ("file", "label", "spacing", "increments"),
    IN_BOUNDARIES: ("boundaries", "centre", "radius", *_SERIES),
    SLIP_PLANE: ("grain", "plane", "centre", "radius", *_SERIES),
}


@dataclass(frozen=True)
class CrackOptions(Options):
    """A crack prescribed by numbers, read from files or made in grains, and its growth; in model units.

    Semi- and quarter-elliptical cracks are ellipses whose centre lies on a face, edge or corner of the box.
    The part of the ellipse outside the box is cut off.
    """

    shape: Shape = option("penny", "kind of crack")
    centre: tuple[float, float, float] | None = option(
        None, "centre of the ellipse; for through_edge a point on the crack mouth", "model units"
    )
    normal: tuple[float, float, float] = option((0.0, 0.0, 1.0), "normal of the crack plane")
    axis: tuple[float, float, float] = option(
        (1.0, 0.0, 0.0), "direction of the first semi-axis, or of the depth (through_edge)"
    )
    radius: float | None = option(
        None, "radius of a penny, or depth of a through edge crack or of a path", "model units", above=0
    )
    semi_axes: tuple[float, float] | None = option(
        None, "semi-axes a, b of an ellipse", "model units", above=0
    )
    file: str | None = option(
        None,
        "input file: triangles (shape surface), cloud (points), CSV (fronts, path), or labels (voxels)",
    )
    front: str | None = option(
        None, "CSV file of the front's points in order; surface, if none: all its boundary within the box"
    )
    label: int | None = option(None, "shape voxels: label of the crack in the file; if none: all except 0")
    spacing: float | None = option(
        None,
        "edge length of the surface fitted to points, fronts or voxels; if none: from their spacing",
        "model units",
        above=0,
    )
    inside: tuple[float, float, float] | None = option(
        None,
        "shape fronts: a point on the cracked side of an open first front; if none: the smaller side",
        "model units",
    )
    scale: float = option(1.0, "shape path: model units per unit of its file", above=0)
    start: float = option(0.0, "shape path: x, in its file, of the path's point that lies at centre")
    slant: float = option(
        0.0,
        "shape path: angle about the axis from the direction normal x axis to the straight front",
        "degrees",
        at_least=-80,
        at_most=80,
    )
    boundaries: tuple[str, ...] | None = option(
        None,
        "shape boundaries: pairs of grains whose common boundaries crack, such as 3-7; with a radius, "
        "only within that distance of centre",
    )
    grain: int | None = option(None, "shape slip_plane: the grain that cracks", at_least=1)
    plane: tuple[int, int, int] | None = option(
        None,
        "shape slip_plane: Miller indices of the plane, its normal in the crystal's axes, such as 1 -1 1",
    )
    growth: float = option(
        0.0, "length added to radius, semi-axes or depth per increment", "model units", at_least=0
    )
    increments: tuple[float | str | tuple[float, float], ...] | None = option(
        None, "size (a, b), radius or file of each increment; replaces growth", above=0
    )

    def __post_init__(self) -> None:
        """Raise CraftmeshError if a value is out of bounds or the shape does not use a given key."""
        super().__post_init__()
        taken = TAKEN[self.shape]
        for item in fields(self):
            value = getattr(self, item.name)
            is_default = value is None or np.array_equal(value, item.default)  # type: ignore[arg-type]
            if item.name not in ("shape", *taken) and not is_default:
                raise CraftmeshError(
                    f"{item.name} is {value!r}, but shape {self.shape} has no such parameter; it has "
                    f"{', '.join(taken)}"
                )


def crack_files(options: CrackOptions, increment: int) -> dict[str, str]:
    """Return the files that the crack of `increment` is read from, by the option that names each file.

    For shape fronts these include the files of all earlier increments. Raise CraftmeshError if
    crack.increments has no entry for `increment`.
    """
    named: dict[str, Any]
    if options.increments and options.shape == "fronts":
        named = {f"increments[{k}]": of_series(options.increments, k) for k in range(increment + 1)}
    elif options.increments:
        named = {"increments": of_series(options.increments, increment), "front": options.front}
    else:
        named = {"file": options.file, "front": options.front}
    return {option: path for option, path in named.items() if isinstance(path, str) and path}


def given_file(options: CrackOptions, increment: int) -> Path:
    """Return the file of `increment` for a shape read from files; raise CraftmeshError if none is given."""
    given = of_series(options.increments, increment) if options.increments else options.file
    if not isinstance(given, str) or not given:
        raise CraftmeshError(
            f"crack.file is {given!r}; expected {BY_FILES[options.shape]}, for shape {options.shape}"
        )
    return Path(given)


def of_series(series: tuple, increment: int) -> Any:
    """Return the size or file in crack.increments for `increment`; raise CraftmeshError if missing."""
    if not 0 <= increment < len(series):
        raise CraftmeshError(
            f"crack.increments has {len(series)} entries, none for increment {increment}; add it"
        )
    return series[increment]

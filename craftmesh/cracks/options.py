"""Options of the crack: its shape, its growth, and the files of a given surface."""

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

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
IN_BOUNDARIES = "boundaries"
SHAPES = (*BY_NUMBERS, *BY_FILES, IN_BOUNDARIES)
_PLANE, _SERIES = ("centre", "normal", "axis"), ("growth", "increments")
# the keys that each shape takes; the others would be left out in silence
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
}


@dataclass(frozen=True)
class CrackOptions(Options):
    """A crack whose shape and growth are prescribed; lengths in model units.

    Semi- and quarter-elliptical cracks are ellipses whose centre lies on a face, edge or corner of the
    box; what lies outside the box is cut off.
    """

    shape: str = option("penny", "kind of crack", choices=SHAPES)
    centre: tuple[float, float, float] | None = option(
        None, "centre of the ellipse; for through_edge a point of the mouth", "model units"
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
        "shape surface: triangles (.vtp, .stl, ...); points: a cloud; fronts, path: csv; voxels: labels",
    )
    front: str | None = option(
        None, "csv of the front's points in order; surface without one: the boundary within the box"
    )
    label: int | None = option(None, "shape voxels: label of the crack in the file; none: any but 0")
    spacing: float | None = option(
        None,
        "edges of a surface that is fitted to points, fronts or voxels; none: as fine as these are",
        "model units",
        above=0,
    )
    inside: tuple[float, float, float] | None = option(
        None,
        "shape fronts: a point on the cracked side of an open first front; none: the smaller side",
        "model units",
    )
    scale: float = option(1.0, "shape path: model units to one of its file", above=0)
    start: float = option(0.0, "shape path: x in its file of the place that lies at centre")
    slant: float = option(
        0.0,
        "shape path: angle about the axis between the crack's lines and the square to axis and normal",
        "degrees",
        at_least=-80,
        at_most=80,
    )
    boundaries: tuple[str, ...] | None = option(
        None,
        "shape boundaries: pairs of grains, such as 3-7, whose boundaries crack; with a radius those "
        "within it of centre",
    )
    growth: float = option(
        0.0, "added to radius, semi-axes or depth at each increment", "model units", at_least=0
    )
    increments: tuple[float | str | tuple[float, float], ...] | None = option(
        None, "(a, b), radius or file of each increment, instead of growth", above=0
    )

    def __post_init__(self) -> None:
        """Raise CraftmeshError for values out of bounds, and for a key that the shape does not take."""
        super().__post_init__()
        taken = TAKEN[self.shape]
        for item in fields(self):
            value = getattr(self, item.name)
            is_default = value is None or np.array_equal(value, item.default)  # type: ignore[arg-type]
            if item.name not in ("shape", *taken) and not is_default:
                raise CraftmeshError(
                    f"{item.name} is {value!r}, which shape {self.shape} does not take; it takes "
                    f"{', '.join(taken)}"
                )


def crack_files(options: CrackOptions, increment: int) -> dict[str, str]:
    """Return the files that the options name for the crack of `increment`, by the option that names each.

    A crack of fronts needs those of the increments before too. Raises CraftmeshError where crack.increments
    holds too few.
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
    """Return the file of `increment` for a shape that comes from files; raises CraftmeshError for none."""
    given = of_series(options.increments, increment) if options.increments else options.file
    if not isinstance(given, str) or not given:
        raise CraftmeshError(
            f"crack.file is {given!r}; expected {BY_FILES[options.shape]}, for shape {options.shape}"
        )
    return Path(given)


def of_series(series: tuple, increment: int) -> Any:
    """Return the size or file that crack.increments holds for `increment`."""
    if not 0 <= increment < len(series):
        raise CraftmeshError(f"increment is {increment}; crack.increments holds {len(series)}: add one")
    return series[increment]

"""Options of the crack: its shape, its growth, and the files of a given surface."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from craftmesh.errors import CraftmeshError
from craftmesh.options import Options, option

SHAPES = ("penny", "ellipse", "through_edge", "surface")


@dataclass(frozen=True)
class CrackOptions(Options):
    """A crack whose shape and growth are prescribed; lengths in model units.

    Semi- and quarter-elliptical cracks are ellipses whose centre lies on a face, edge or corner of the
    box; what lies outside the box is cut off.
    """

    shape: str = option("penny", "kind of crack", choices=SHAPES)
    centre: tuple[float, float, float] = option(
        (0.0, 0.0, 0.0), "centre of the ellipse; for through_edge a point of the mouth", "model units"
    )
    normal: tuple[float, float, float] = option((0.0, 0.0, 1.0), "normal of the crack plane")
    axis: tuple[float, float, float] = option(
        (1.0, 0.0, 0.0), "direction of the first semi-axis, or of the depth (through_edge)"
    )
    radius: float | None = option(
        None, "radius of a penny, or depth of a through edge crack", "model units", above=0
    )
    semi_axes: tuple[float, float] | None = option(
        None, "semi-axes a, b of an ellipse", "model units", above=0
    )
    file: str | None = option(
        None, "triangulated surface (.vtp, .stl, .ply, .obj, .off or .3mf) for shape surface"
    )
    front: str | None = option(None, "csv file of the front's points; none: the boundary within the box")
    growth: float = option(
        0.0, "added to radius, semi-axes or depth at each increment", "model units", at_least=0
    )
    increments: tuple[float | str | tuple[float, float], ...] | None = option(
        None, "(a, b), radius or file of each increment, instead of growth", above=0
    )


def crack_files(options: CrackOptions, increment: int) -> dict[str, str]:
    """Return the files that the options name for the crack of `increment`, by the option that names each.

    Raises CraftmeshError where crack.increments holds too few.
    """
    if options.increments:
        named = {"increments": of_series(options.increments, increment), "front": options.front}
    else:
        named = {"file": options.file, "front": options.front}
    return {option: path for option, path in named.items() if isinstance(path, str) and path}


def surface_file(options: CrackOptions, increment: int) -> Path:
    """Return the file of the triangulated surface of `increment`; raises CraftmeshError for none."""
    files = crack_files(options, increment)
    name = files.get("increments" if options.increments else "file")
    if name is None:
        given = of_series(options.increments, increment) if options.increments else options.file
        raise CraftmeshError(
            f"crack.file is {given!r}; expected a .vtp, .stl, .ply, .obj, .off or .3mf for shape surface"
        )
    return Path(name)


def of_series(series: tuple, increment: int) -> Any:
    """Return the size or file that crack.increments holds for `increment`."""
    if not 0 <= increment < len(series):
        raise CraftmeshError(f"increment is {increment}; crack.increments holds {len(series)}: add one")
    return series[increment]

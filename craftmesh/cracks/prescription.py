"""The parts of a crack that its options fix without a box or a file: plane, sizes, and pairs of grains."""

from typing import Any

import numpy as np

from craftmesh.cracks.options import (
    BY_FILES,
    BY_NUMBERS,
    IN_BOUNDARIES,
    OF_GRAINS,
    SLIP_PLANE,
    CrackOptions,
    given_file,
    of_series,
)
from craftmesh.errors import CraftmeshError

_SIZES = ("a radius or depth > 0", "semi_axes a, b > 0")


def check_crack(options: CrackOptions, increment: int) -> None:
    """Raise CraftmeshError, naming the key, if these options make no crack with any box and any files."""
    if options.shape in BY_FILES:
        given_file(options, increment)
    if options.shape == "points" and not options.front:
        raise CraftmeshError("crack.front is not given; give the CSV file of the front of the point cloud")
    if options.shape == IN_BOUNDARIES:
        boundary_pairs(options)
    if options.shape == SLIP_PLANE and not (options.grain and np.any(options.plane)):
        raise CraftmeshError(
            f"crack.grain is {_shown(options.grain)} and crack.plane {_shown(options.plane)}; shape "
            "slip_plane needs a grain and Miller indices that are not all 0"
        )
    if is_sized(options):
        sizes = semi_axes(options, increment)
        if options.shape != SLIP_PLANE:
            vector("centre", options.centre)
        if options.shape not in OF_GRAINS:
            frame_of(options, sizes)


def is_sized(options: CrackOptions) -> bool:
    """Return whether the options give the crack a size; shapes OF_GRAINS have one only with a radius."""
    if options.shape in OF_GRAINS:
        return options.radius is not None or bool(options.increments)
    return options.shape in (*BY_NUMBERS, "path")


def changing(options: CrackOptions, increment: int) -> tuple:
    """Return the values that change with the increment: the semi-axes, the file, or an empty tuple."""
    if is_sized(options):
        return semi_axes(options, increment)
    return (given_file(options, increment),) if options.shape in BY_FILES else ()


def semi_axes(options: CrackOptions, increment: int) -> tuple[float, float]:
    """Return the semi-axes (a, b) of an increment; a = b for penny (radius) and through crack (depth)."""
    key = "semi_axes" if options.shape == "ellipse" else "radius"
    if options.increments:
        key, sizes, grown = f"increments[{increment}]", of_series(options.increments, increment), 0
    else:
        sizes, grown = getattr(options, key), increment
    try:
        pair = np.broadcast_to(np.asarray(sizes, float), (2,)) + grown * options.growth
    except (TypeError, ValueError):
        pair = np.full(2, np.nan)
    if not (np.isfinite(pair).all() and (pair > 0).all()):
        raise CraftmeshError(
            f"crack.{key} is {_shown(sizes)}; expected {_SIZES[options.shape == 'ellipse']}, for shape "
            f"{options.shape}"
        )
    return float(pair[0]), float(pair[1])


def frame_of(options: CrackOptions, sizes: tuple[float, float]) -> np.ndarray:
    """Return rows axis, normal x axis, normal (3, 3) of a crack plane; `sizes`: the crack's semi-axes."""
    normal, axis = vector("normal", options.normal), vector("axis", options.axis)
    if not np.linalg.norm(normal) > 0:
        raise CraftmeshError(f"crack.normal is {normal.tolist()}; expected a vector that is not zero")
    is_round = options.shape in ("penny", "ellipse") and sizes[0] == sizes[1]
    if is_round and _is_along(axis, normal):
        axis = np.roll(axis, 1)  # a circle allows any axis; the default x is invalid if the normal is x
    if not axis.any() or _is_along(axis, normal):
        raise CraftmeshError(
            f"crack.axis is {axis.tolist()} and crack.normal is {normal.tolist()}; give a non-zero axis "
            "that is not parallel to the normal"
        )
    return frame_along(normal, axis)


def frame_along(normal: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Return right-handed rows u, v, normal (3, 3); u is `axis` projected onto the plane of `normal`."""
    normal = normal / np.linalg.norm(normal)
    u = axis - (axis @ normal) * normal
    u = u / np.linalg.norm(u)
    return np.stack([u, np.cross(normal, u), normal])


def boundary_pairs(options: CrackOptions) -> np.ndarray:
    """Return the pairs of grains (k, 2) listed in options.boundaries, the lower id first."""
    pairs = []
    for text in options.boundaries or ():
        words = text.split("-")
        if len(words) != 2 or not all(word.strip().isdecimal() for word in words):
            raise CraftmeshError(f"crack.boundaries has {text!r}; expected two grains, such as 3-7")
        pairs.append(sorted(map(int, words)))
    if not pairs:
        raise CraftmeshError("crack.boundaries is not given; expected pairs of grains, such as 3-7")
    return np.array(pairs)


def vector(name: str, value: Any) -> np.ndarray:
    """Return the value of the crack option `name` as (3,); CraftmeshError unless it is 3 finite numbers."""
    try:
        found = np.asarray(value, float)
    except (TypeError, ValueError):
        found = np.zeros(0)
    if found.shape != (3,) or not np.isfinite(found).all():
        raise CraftmeshError(f"crack.{name} is {_shown(value)}; expected three finite numbers")
    return found


def _shown(value: Any) -> str:
    return "not given" if value is None else repr(value)


def _is_along(axis: np.ndarray, normal: np.ndarray) -> bool:
    return bool(
        np.linalg.norm(np.cross(normal, axis)) <= 1e-6 * np.linalg.norm(normal) * np.linalg.norm(axis)
    )

"""Checks of data files that accompany a body: position, unit, ids and coverage must fit the body."""

from collections.abc import Iterable

import numpy as np
import scipy

from craftmesh.errors import CraftmeshError, listed, rounded_values
from craftmesh.surface.measure import span_of
from craftmesh.surface.rounding import ON_PLANE
from craftmesh.types import Voxels

# Pairs of units by the power of ten between their numbers for one length; larger numbers first.
UNITS = {1: ("mm", "cm"), 2: ("cm", "m"), 3: ("um", "mm"), 6: ("um", "m"), 9: ("nm", "m")}


def size_of(span: np.ndarray) -> float:
    """Return the diagonal of a span (2, 3)."""
    return float(np.linalg.norm(span[1] - span[0]))


def are_apart(first: np.ndarray, second: np.ndarray, gap: float = 0.0) -> bool:
    """Return whether two bounding boxes (2, 3) are more than a gap apart along an axis."""
    return bool((np.maximum(first[0], second[0]) > np.minimum(first[1], second[1]) + gap).any())


def spans_told(names: tuple[str, str], first: np.ndarray, second: np.ndarray) -> str:
    """Return a text with the names and limits of two bounding boxes (2, 3)."""
    return ", ".join(
        f"{name} from {rounded_values(low)} to {rounded_values(high)}"
        for name, (low, high) in zip(names, (first, second))
    )


def power_apart(first: np.ndarray, second: np.ndarray, ratio: float | None = None) -> int:
    """Return the power of ten between the units of two bounding boxes (2, 3), or 0.

    ratio: quotient of two sizes that should be equal; None: the diagonals. The power is 0 if dividing the
    first box by it does not make the boxes overlap.
    """
    if ratio is None:
        sizes = size_of(first), size_of(second)
        ratio = sizes[0] / sizes[1] if min(sizes) else 0.0
    power = round(float(np.log10(ratio))) if ratio > 0 else 0
    return 0 if are_apart(first / 10.0**power, second) else power


def unit_hint(first: np.ndarray, second: np.ndarray, ratio: float | None = None) -> str:
    """Return a text for errors if the units of two boxes (2, 3) seem to differ by a power of ten, else "".

    ratio: quotient of two sizes that should be equal, the first box's by the second's; None: the diagonals.
    """
    return power_told(power_apart(first, second, ratio))


def power_told(power: int) -> str:
    """Return a text that numbers are about 10^power times as large, with a guess of units; "" for 0."""
    if not power:
        return ""
    text = f", about {10 ** abs(power)} times as {'large' if power > 0 else 'small'}"
    if abs(power) not in UNITS:
        return text
    fine, coarse = UNITS[abs(power)]
    return f"{text} ({f'{fine} beside {coarse}' if power > 0 else f'{coarse} beside {fine}'}?)"


def coordinates_hint(first: np.ndarray, second: np.ndarray) -> str:
    """Return `unit_hint` by the ratio of largest coordinates; data may cover only part of a body."""
    return unit_hint(first, second, _coordinates_ratio(first, second))


def _coordinates_ratio(first: np.ndarray, second: np.ndarray) -> float:
    return float(np.abs(first).max() / np.abs(second).max())


def notes_on_place(
    what: str, points: np.ndarray, box: np.ndarray, reach: float = 0.0, least: float = 0.0
) -> list[str]:
    """Return a note if some points (n, 3) lie outside the box (2, 3) or seem to have another unit.

    what: begins the note. Another unit is assumed if coordinates differ by a factor of about 100 or more;
    this is tested only if all points lie in the box. Raise CraftmeshError if no point lies within `reach`
    of the box, or if several points in another unit span less than `least`.
    """
    span, gap = span_of(points), np.linalg.norm(points - np.clip(points, *box), axis=1)
    off = gap > ON_PLANE * size_of(box)
    is_small = not off.any() and abs(power_apart(span, box, _coordinates_ratio(span, box))) > 1
    if not off.any() and not is_small:
        return []
    text = f"{what}: " + (f"{off.sum()} of {len(off)} points lie outside the body; " if off.any() else "")
    text += spans_told(("the points go", "the body"), span, box) + coordinates_hint(span, box)
    if (gap > reach).all() or (is_small and 0 < size_of(span) < least):
        raise CraftmeshError(f"{text}; give the points in the unit and position of the body")
    return [text]


def covered(
    places: np.ndarray, points: np.ndarray, count: int, reach: np.ndarray | float = 0.0
) -> tuple[np.ndarray, str]:
    """Return a mask (q,) of places (q, 3) that a field's points (n, 3) cover, and a text on both.

    A place is covered if the distance to its nearest point is at most `reach`, or at most the distance from
    that point to the farthest of its `count` nearest points (itself included). A single point covers all
    places.
    """
    tree = scipy.spatial.cKDTree(points)
    distance, nearest = tree.query(places)
    spread = tree.query(points[nearest], k=[min(count, len(points))])[0][:, 0]
    is_covered = (distance <= np.maximum(spread, reach)) | (len(points) == 1)
    spans = span_of(points), span_of(places)
    text = f"the farthest place is {distance.max():.4g} away from its points: "
    return is_covered, text + spans_told(("the points go", "the places"), *spans) + coordinates_hint(*spans)


def notes_on_ids(what: str, given: Iterable[int], grains: Iterable[int]) -> list[str]:
    """Return a note if a table has ids that are no grains of the mesh, else none.

    what: begins the note. given: the table's ids. Raise CraftmeshError if a grain has no row.
    """
    given, grains = set(given), set(grains)
    if missing := sorted(grains - given):
        raise CraftmeshError(
            f"{what}: no row for {len(missing)} of {len(grains)} grains: {listed(missing)}; the table has "
            f"{listed(sorted(given))}; give one row per grain"
        )
    other = sorted(given - grains)
    return [f"{what}: ignored the ids {listed(other)}, which no grain of the mesh has"] if other else []


def place_beside(
    marked: np.ndarray, spacing: np.ndarray | None, origin: np.ndarray, grid: Voxels
) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Return spacing (3,) and origin (3,) of marked voxels (nx, ny, nz) in a grid's frame, and notes.

    spacing, origin: from the file; spacing may be None. Voxels with the grid's shape get the grid's
    position if the file has none, or has the placeholder of some programs, a spacing of 1 from about 0 on.
    Raise CraftmeshError for another shape without spacing, exchanged axes, the grid's shape in another
    size, and marked voxels that all lie outside the grid's box.
    """
    shape, own = marked.shape, grid.labels.shape
    if shape != own and sorted(shape) == sorted(own):
        raise CraftmeshError(
            f"the file has {shape} voxels along x, y, z, the microstructure {own}; exchange the file's axes"
        )
    is_bare = spacing is None or bool((spacing == 1).all() and (grid.spacing != 1).any())
    if shape != own and is_bare:
        raise CraftmeshError(
            f"the file has {shape} voxels and no spacing{'' if spacing is None else ' except 1'}, but the "
            f"microstructure has {own}; give as many voxels, or a format with spacing and origin"
        )
    if spacing is None:
        return grid.spacing, grid.origin, []
    box = np.stack([origin, origin + spacing * shape])
    spans = spans_told(("the voxels go", "the microstructure"), box, grid.box)
    is_near = (np.abs(box - grid.box) <= grid.spacing / 2).all()
    is_unset = (np.abs(origin) <= spacing / 2).all() and (is_bare or (spacing == grid.spacing).all())
    if shape == own and (is_near or is_unset):
        note = f"the file's voxels are placed on the microstructure's, of equal shape; in the file {spans}"
        return grid.spacing, grid.origin, [] if is_near else [note]
    hint = unit_hint(box, grid.box)
    if shape == own and not np.allclose(spacing, grid.spacing, rtol=0.5 / max(shape)):
        raise CraftmeshError(
            f"the file has as many voxels as the microstructure, {shape}, of another size: {spans}{hint}; "
            "give the file the microstructure's spacing and origin, or no spacing at all"
        )
    centres = origin + (np.argwhere(marked) + 0.5) * spacing
    off = ((centres < grid.box[0]) | (centres > grid.box[1])).any(axis=1)
    text = f"the file's voxels form another grid: {spans}{hint}; "
    text += f"{off.sum()} of {len(off)} marked voxels lie outside"
    if off.all():
        raise CraftmeshError(f"{text}; give the voxels in the unit and position of the microstructure")
    return spacing, origin, [text]

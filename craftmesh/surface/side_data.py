"""Data that lie beside a body: whether place, unit, numbers and coverage are those of the body."""

from collections.abc import Iterable

import numpy as np
import scipy

from craftmesh.errors import CraftmeshError, listed, told
from craftmesh.surface.measure import span_of
from craftmesh.surface.rounding import ON_PLANE
from craftmesh.types import Voxels

# Units whose numbers for one length are 10 to that power apart, the one with the larger numbers first.
UNITS = {1: ("mm", "cm"), 2: ("cm", "m"), 3: ("um", "mm"), 6: ("um", "m"), 9: ("nm", "m")}


def size_of(span: np.ndarray) -> float:
    """Return the diagonal of a span (2, 3)."""
    return float(np.linalg.norm(span[1] - span[0]))


def are_apart(first: np.ndarray, second: np.ndarray, gap: float = 0.0) -> bool:
    """Tell whether two spans (2, 3) have no place in common, and more than a gap between them."""
    return bool((np.maximum(first[0], second[0]) > np.minimum(first[1], second[1]) + gap).any())


def spans_told(names: tuple[str, str], first: np.ndarray, second: np.ndarray) -> str:
    """Return in words what two spans (2, 3) with these names are."""
    return ", ".join(
        f"{name} from {told(low)} to {told(high)}" for name, (low, high) in zip(names, (first, second))
    )


def power_apart(first: np.ndarray, second: np.ndarray, ratio: float | None = None) -> int:
    """Return the power of ten that parts two spans (2, 3), 0 for none.

    ratio: of sizes that should be alike, that of the spans where it is None. The power has to bring the
    first span to where the second one is.
    """
    if ratio is None:
        sizes = size_of(first), size_of(second)
        ratio = sizes[0] / sizes[1] if min(sizes) else 0.0
    power = round(float(np.log10(ratio))) if ratio > 0 else 0
    return 0 if are_apart(first / 10.0**power, second) else power


def unit_hint(first: np.ndarray, second: np.ndarray, ratio: float | None = None) -> str:
    """Return `power_told` of `power_apart`."""
    return power_told(power_apart(first, second, ratio))


def power_told(power: int) -> str:
    """Return in words that numbers are 10 to a power times as large, and of which units; "" for 0."""
    if not power:
        return ""
    text = f", about {10 ** abs(power)} times as {'large' if power > 0 else 'small'}"
    if abs(power) not in UNITS:
        return text
    fine, coarse = UNITS[abs(power)]
    return f"{text} ({f'{fine} beside {coarse}' if power > 0 else f'{coarse} beside {fine}'}?)"


def coordinates_hint(first: np.ndarray, second: np.ndarray) -> str:
    """Return `unit_hint` of two spans (2, 3) by largest coordinates: data may lie in part of a body."""
    return unit_hint(first, second, _coordinates_ratio(first, second))


def _coordinates_ratio(first: np.ndarray, second: np.ndarray) -> float:
    return float(np.abs(first).max() / np.abs(second).max())


def notes_on_place(
    what: str, points: np.ndarray, box: np.ndarray, reach: float = 0.0, least: float = 0.0
) -> list[str]:
    """Return a sentence on points (n, 3) of which some lie outside the box (2, 3), or in another unit.

    what: begins the sentence. Another unit: a power of ten from 100 on parts their coordinates. Raises
    CraftmeshError where no point lies within `reach` of the box, and for several points in another unit
    that span less than `least`.
    """
    span, gap = span_of(points), np.linalg.norm(points - np.clip(points, *box), axis=1)
    off = gap > ON_PLANE * size_of(box)
    is_small = not off.any() and abs(power_apart(span, box, _coordinates_ratio(span, box))) > 1
    if not off.any() and not is_small:
        return []
    text = f"{what}: " + (f"{off.sum()} of {len(off)} points lie outside the body; " if off.any() else "")
    text += spans_told(("they go", "the body"), span, box) + coordinates_hint(span, box)
    if (gap > reach).all() or (is_small and 0 < size_of(span) < least):
        raise CraftmeshError(f"{text}; expected them in the unit and place of the body")
    return [text]


def covered(
    places: np.ndarray, points: np.ndarray, count: int, reach: np.ndarray | float = 0.0
) -> tuple[np.ndarray, str]:
    """Return mask (q,) of places (q, 3) that the points (n, 3) of a field cover, and where both lie.

    A place is covered where its nearest point is within `reach`, or no farther than the farthest of the
    `count` points nearest to that point, itself one of them. One point alone covers all places.
    """
    tree = scipy.spatial.cKDTree(points)
    distance, nearest = tree.query(places)
    spread = tree.query(points[nearest], k=[min(count, len(points))])[0][:, 0]
    is_covered = (distance <= np.maximum(spread, reach)) | (len(points) == 1)
    spans = span_of(points), span_of(places)
    text = f"the farthest place is {distance.max():.4g} off its points: "
    return is_covered, text + spans_told(("they go", "the places"), *spans) + coordinates_hint(*spans)


def notes_on_ids(what: str, given: Iterable[int], grains: Iterable[int]) -> list[str]:
    """Return a sentence on ids of a table that are no grains of the mesh, or none.

    what: begins the sentence. Raises CraftmeshError where a grain has no row.
    """
    given, grains = set(given), set(grains)
    if missing := sorted(grains - given):
        raise CraftmeshError(
            f"{what}: no row for {len(missing)} of {len(grains)} grains: {listed(missing)}; expected one "
            f"for each; the table has {listed(sorted(given))}"
        )
    other = sorted(given - grains)
    return [f"{what}: no grain of the mesh has the ids {listed(other)}; left out"] if other else []


def place_beside(
    marked: np.ndarray, spacing: np.ndarray | None, origin: np.ndarray, grid: Voxels
) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Return the spacing (3,) and origin (3,) of marked voxels (nx, ny, nz) beside a grid's, and notes.

    spacing: the file's, None without one. Voxels of the grid's shape have the grid's place where the file
    has none, or a spacing of 1 from about 0 on, which programs write for none. Raises CraftmeshError for
    another shape without spacing, axes that are exchanged, the grid's shape in another size, and marked
    voxels that all lie outside the grid's box.
    """
    shape, own = marked.shape, grid.labels.shape
    if shape != own and sorted(shape) == sorted(own):
        raise CraftmeshError(
            f"has {shape} voxels along x, y, z, and the microstructure {own}; exchange its axes"
        )
    is_bare = spacing is None or bool((spacing == 1).all() and (grid.spacing != 1).any())
    if shape != own and is_bare:
        raise CraftmeshError(
            f"has {shape} voxels and no spacing{'' if spacing is None else ' but 1'}; expected those of "
            f"the microstructure, {own}, or a format with spacing and origin"
        )
    if spacing is None:
        return grid.spacing, grid.origin, []
    box = np.stack([origin, origin + spacing * shape])
    spans = spans_told(("they go", "the microstructure"), box, grid.box)
    is_near = (np.abs(box - grid.box) <= grid.spacing / 2).all()
    is_unset = (np.abs(origin) <= spacing / 2).all() and (is_bare or (spacing == grid.spacing).all())
    if shape == own and (is_near or is_unset):
        note = f"its voxels are taken for the microstructure's, whose shape they have: by the file {spans}"
        return grid.spacing, grid.origin, [] if is_near else [note]
    hint = unit_hint(box, grid.box)
    if shape == own and not np.allclose(spacing, grid.spacing, rtol=0.5 / max(shape)):
        raise CraftmeshError(
            f"has the microstructure's {shape} voxels in another size: {spans}{hint}; give them its "
            "spacing and origin, or none"
        )
    centres = origin + (np.argwhere(marked) + 0.5) * spacing
    off = ((centres < grid.box[0]) | (centres > grid.box[1])).any(axis=1)
    text = f"its voxels are of another grid: {spans}{hint}; "
    text += f"{off.sum()} of {len(off)} marked voxels lie outside"
    if off.all():
        raise CraftmeshError(f"{text}; expected them in the unit and place of the microstructure")
    return spacing, origin, [text]

"""What two sets of points span, held against each other: apart, or in another unit."""

import numpy as np

from craftmesh.errors import told

# Units whose numbers for one length are 10 to that power apart, the one with the larger numbers first.
UNITS = {1: ("mm", "cm"), 2: ("cm", "m"), 3: ("um", "mm"), 6: ("um", "m"), 9: ("nm", "m")}


def span_of(points: np.ndarray) -> np.ndarray:
    """Return the least and the most coordinates (2, 3) of points (..., 3)."""
    points = points.reshape(-1, 3)
    return np.stack([points.min(axis=0), points.max(axis=0)])


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


def unit_hint(first: np.ndarray, second: np.ndarray, ratio: float | None = None) -> str:
    """Return in words what power of ten parts two spans (2, 3), and which units do so; empty for none.

    ratio: of sizes that should be alike, that of the spans where it is None. The power has to bring the
    first span to where the second one is.
    """
    sizes = size_of(first), size_of(second)
    if min(sizes) == 0:
        return ""
    power = round(float(np.log10(sizes[0] / sizes[1] if ratio is None else ratio)))
    if not power or are_apart(first / 10.0**power, second):
        return ""
    text = f", about {10 ** abs(power)} times as {'large' if power > 0 else 'small'}"
    if abs(power) not in UNITS:
        return text
    fine, coarse = UNITS[abs(power)]
    return f"{text} ({f'{fine} beside {coarse}' if power > 0 else f'{coarse} beside {fine}'}?)"

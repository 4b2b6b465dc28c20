"""The costly invariants of a surface; each violation gives one sentence."""

import numpy as np

from craftmesh.arguments import typed
from craftmesh.errors import CraftmeshError
from craftmesh.surface.connectivity import open_edges
from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.surface.measure import area_vectors, is_degenerate, volumes_of
from craftmesh.surface.patches import PLANES, is_on_box
from craftmesh.types import BORDER, BOX_PLANES, CRACK, Surface


@typed
def check_surface(surface: Surface) -> list[str]:
    """Return one sentence per kind of violated invariant; an empty list if the surface is valid.

    Checked are: unused points; degenerate and duplicate facets; consistency of sides and kinds; box planes;
    closedness, orientation and volume of each grain and void; intersections. Crack facets inside a grain
    belong to no boundary.
    """
    if not len(surface.facets):
        return ["the surface has no facets"]
    checks = (_points, _shapes, _duplicates, _labels, _planes, _closedness, _volumes, _intersections)
    return [breach for check in checks for breach in check(surface)]


def refuse_open(surface: Surface) -> dict[int, float]:
    """Return the volumes of grains and voids, as `side_volumes` does.

    Raises CraftmeshError unless each grain's facets are closed and face outward around a volume > 0.
    """
    volumes = volumes_of(surface)
    breaches = _closedness(surface) or _no_volumes(volumes)
    if breaches:
        raise CraftmeshError(f"{breaches[0]}; expected closed boundaries that face out of their grains")
    return volumes


def _at(point: np.ndarray) -> str:
    return "at (" + ", ".join(f"{x:.6g}" for x in point) + ")"


def _some(labels: np.ndarray) -> str:
    """Return the names of at most five labels as text."""
    found = np.unique(labels)
    names = [f"grain {g}" if g > 0 else f"void {-g}" if g < 0 else "outside" for g in found[:5].tolist()]
    return ", ".join(names) + (f" and {len(found) - 5} more" if len(found) > 5 else "")


def _facets_breach(surface: Surface, bad: np.ndarray, what: str) -> list[str]:
    """Return a list with a sentence that the facets in the mask `bad` (m,) have the fault `what`, or []."""
    if not bad.any():
        return []
    place = _at(surface.points[surface.facets[bad.argmax()]].mean(axis=0))
    return [f"{bad.sum()} facets {what}, between {_some(surface.sides[bad])}; first {place}"]


def _points(surface: Surface) -> list[str]:
    used = np.zeros(len(surface.points), bool)
    used[surface.facets.ravel()] = True
    if used.all():
        return []
    return [f"{(~used).sum()} points belong to no facet; first {_at(surface.points[used.argmin()])}"]


def _shapes(surface: Surface) -> list[str]:
    return _facets_breach(surface, is_degenerate(surface.points, surface.facets), "are degenerate")


def _duplicates(surface: Surface) -> list[str]:
    key = np.sort(surface.facets, axis=1)
    _, index, count = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    return _facets_breach(surface, count[index.reshape(-1)] > 1, "lie on the same three points as another")


def _labels(surface: Surface) -> list[str]:
    behind, ahead = surface.sides.T
    kind = surface.kind
    on_box = is_on_box(kind)
    return (
        _facets_breach(surface, kind > BORDER, f"have a kind above {BORDER}")
        + _facets_breach(surface, (behind <= 0) & (ahead <= 0), "bound no grain")
        + _facets_breach(surface, (behind == ahead) & (kind != CRACK), "have the same grain on both sides")
        + _facets_breach(surface, on_box & (behind != 0) & (ahead != 0), "on the box have no outside")
    )


def _planes(surface: Surface) -> list[str]:
    """Check that facets of a box plane lie on it exactly and face outward, with no point beyond it."""
    breaches = []
    outward = np.where(surface.sides[:, 0] > 0, 1, -1)[:, None] * area_vectors(
        surface.points, surface.facets
    )
    for (plane, axis, upper), name in zip(PLANES, BOX_PLANES):
        mine = surface.kind == plane
        if not mine.any():
            continue
        reach = surface.points[:, axis].max() if upper else surface.points[:, axis].min()
        off = mine & (surface.points[surface.facets][:, :, axis] != reach).any(axis=1)
        inward = mine & ~off & (outward[:, axis] * (1 if upper else -1) < 0)
        breaches += _facets_breach(
            surface, off, f"of {name} are not exactly on the outermost plane {reach:.17g}"
        )
        breaches += _facets_breach(surface, inward, f"of {name} have their grain outside the box")
    return breaches


def _closedness(surface: Surface) -> list[str]:
    """Check that each directed edge of a grain's boundary has as many partners in the other direction."""
    if not surface.sides[surface.sides[:, 0] != surface.sides[:, 1]].any():
        return ["no facet bounds a grain"]
    found = open_edges(surface.facets, surface.sides, len(surface.points))
    if not len(found):
        return []
    first = _at(surface.points[found[0, 1:]].mean(axis=0))
    return [
        f"{len(found)} edges have no partner, so the boundary is open or not oriented consistently: "
        f"{_some(found[:, 0])}; first {first}"
    ]


def _volumes(surface: Surface) -> list[str]:
    return _no_volumes(volumes_of(surface))


def _no_volumes(volumes: dict[int, float]) -> list[str]:
    return [
        f"grain {grain} has the volume {volume:.6g}, so its facets are turned inside out or missing"
        for grain, volume in volumes.items()
        if not volume > 0
    ]


def _intersections(surface: Surface) -> list[str]:
    repeats = (surface.facets == np.roll(surface.facets, 1, axis=1)).any(axis=1)
    sound = np.flatnonzero(~repeats)  # facets that repeat a point are degenerate, which _shapes reports
    pairs = sound[intersecting_pairs(surface.points, surface.facets[sound])]
    if not len(pairs):
        return []
    places = [_at(surface.points[surface.facets[pair]].mean(axis=(0, 1))) for pair in pairs[:3]]
    labels = _some(surface.sides[pairs.ravel()])
    return [f"{len(pairs)} pairs of facets intersect, between {labels}; first {', '.join(places)}"]

"""Checks of a deck's tetrahedra: flat ones, shapes, sizes, volumes of the grains, conformity."""

import numpy as np

from craftmesh.types import Surface
from trials.deck_file import FACES, DeckFile
from trials.distances import told
from trials.drawing import Drawn
from trials.wedges import local_least, wedges

EDGES = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]])
FLAT = {"least": 5.0, "largest": 172.0, "shape": 0.005}
POOR = {"least": 10.0, "largest": 160.0, "shape": 0.02}


def measures(corners: np.ndarray) -> dict[str, np.ndarray]:
    """Return volume, aspect ratio, least and largest dihedral angle and shape factor of tets (m, 4, 3)."""
    normals = []
    for face in FACES:
        p, q, r = (corners[:, i] for i in face)
        normals.append(np.cross(q - p, r - p))
    normal = np.stack(normals, axis=1)
    doubled = np.maximum(np.linalg.norm(normal, axis=2), 1e-300)
    volume = np.einsum("ij,ij->i", -normal[:, 0], corners[:, 0] - corners[:, 3]) / 6
    length = np.linalg.norm(corners[:, EDGES[:, 0]] - corners[:, EDGES[:, 1]], axis=2)
    altitude = 6 * np.abs(volume)[:, None] / doubled
    unit = normal / doubled[..., None]
    cosine = [np.einsum("ij,ij->i", unit[:, i], unit[:, j]) for i in range(4) for j in range(i)]
    dihedral = 180 - np.degrees(np.arccos(np.clip(np.stack(cosine, axis=1), -1, 1)))
    products = np.stack([length[:, i] * length[:, 5 - i] for i in range(3)], axis=1)
    half = products.sum(axis=1) / 2
    heron = np.maximum(half * (half - products.T).prod(axis=0), 0)
    radius = np.sqrt(heron) / np.maximum(6 * np.abs(volume), 1e-300)
    shape = np.abs(volume) / np.maximum(8 * np.sqrt(3) / 27 * radius**3, 1e-300)
    aspect = length.max(axis=1) / np.maximum(altitude.min(axis=1), 1e-300)
    return {
        "volume": volume,
        "aspect": aspect,
        "least": dihedral.min(axis=1),
        "largest": dihedral.max(axis=1),
        "shape": shape,
    }


def beyond(found: dict[str, np.ndarray], limits: dict[str, float]) -> np.ndarray:
    """Return where tets break one of the limits: least and largest dihedral angle, shape factor."""
    low = (found["least"] < limits["least"]) | (found["shape"] < limits["shape"])
    return low | (found["largest"] > limits["largest"])


def check_tets(case: Drawn, deck: DeckFile, inserted: Surface, gradated: Surface, sizing) -> dict:
    """Return the quality figures and the flat tets that no wedge of the input forces."""
    found = measures(deck.points[deck.corners])
    report = {
        "tets": len(deck.tets),
        "inverted": int((found["volume"] <= 0).sum()),
        "ar_mean": float(found["aspect"].mean()),
        "ar_under_5_pct": float(100 * (found["aspect"] < 5).mean()),
        "poor_pct": float(100 * beyond(found, POOR).mean()),
        "dihedral_min": float(found["least"].min()),
        "dihedral_max": float(found["largest"].max()),
        "shape_min": float(found["shape"].min()),
    }
    flat = np.flatnonzero(beyond(found, FLAT))
    report |= _flat(deck, found, flat, inserted, gradated, sizing)
    return report | _volumes(case, deck, found["volume"]) | _conformity(deck)


def _flat(
    deck: DeckFile, found: dict, flat: np.ndarray, inserted: Surface, gradated: Surface, sizing
) -> dict:
    """Return counts of flat tets, and how many the wedges of the two surfaces there do not explain."""
    if not len(flat):
        return {"flat": 0, "flat_unforced": 0}
    places = deck.points[deck.corners[flat]].mean(axis=1)
    sharpest = np.minimum(found["least"][flat], 180 - found["largest"][flat])
    by = {}
    for name, surface in (("input", inserted), ("surface", gradated)):
        edges, angle, _ = wedges(surface)
        by[name] = local_least(surface, edges, angle, places, sizing)
    free = by["input"] >= FLAT["least"]
    worst = int(np.where(free, sharpest, np.inf).argmin()) if free.any() else int(sharpest.argmin())
    row = flat[worst]
    return {
        "flat": len(flat),
        "flat_unforced": int(free.sum()),
        "flat_in_gradated_wedge": int((free & (by["surface"] < FLAT["least"])).sum()),
        "flat_worst": [float(found[key][row]) for key in ("least", "largest", "shape")],
        "flat_at": told(places[worst]),
        "flat_in": int(deck.grain[row]),
        "flat_wedges": [float(min(by[name][worst], 180)) for name in ("input", "surface")],
        "flat_facet": _least_facet_angle(gradated, deck.points[deck.corners[row]]),
    }


def _least_facet_angle(surface: Surface, corners: np.ndarray) -> float:
    """Return the least angle of the surface's facets that have a corner where a tet (4, 3) has one."""
    near = np.ptp(corners, axis=0).max() * 1e-6
    own = np.zeros(len(surface.points), bool)
    for corner in corners:
        own |= np.abs(surface.points - corner).max(axis=1) < near
    facets = surface.points[surface.facets[own[surface.facets].any(axis=1)]]
    if not len(facets):
        return 180.0
    side = np.roll(facets, -1, axis=1) - facets
    back = -np.roll(side, 1, axis=1)
    cross = np.linalg.norm(np.cross(side, back), axis=2)
    return float(np.degrees(np.arctan2(cross, np.einsum("ijk,ijk->ij", side, back))).min())


def _volumes(case: Drawn, deck: DeckFile, volume: np.ndarray) -> dict:
    """Return the drift of the grains' volumes from their voxels in percent, and grains lost or unknown."""
    labels, count = np.unique(case.voxels.labels[case.voxels.labels > 0], return_counts=True)
    meshed = np.bincount(deck.grain, np.abs(volume), int(max(labels.max(), deck.grain.max())) + 1)
    drift = 100 * np.abs(meshed[labels] / (count * case.voxels.spacing.prod()) - 1)
    large = drift[count > 500]
    return {
        "drift_mean_pct": float(drift.mean()),
        "drift_large_pct": float(large.max(initial=0.0)),
        "grains_lost": int((meshed[labels] == 0).sum()),
        "grains_unknown": len(np.setdiff1d(deck.grain, labels)),
    }


def _conformity(deck: DeckFile) -> dict:
    """Return faces in over two tets, free faces in no named surface, and lip faces without a partner."""
    faces = deck.corners[:, FACES].reshape(-1, 3)
    _, inverse, count = np.unique(np.sort(faces, axis=1), axis=0, return_inverse=True, return_counts=True)
    count = count[inverse.ravel()]
    named = np.zeros(len(faces), bool)
    for rows in deck.surfaces.values():
        named[4 * rows[:, 0] + rows[:, 1]] = True
    pairs = [_places(deck, side) for side in "AB"]
    both, times = np.unique(np.concatenate(pairs), axis=0, return_counts=True)
    return {
        "faces_over_two": int((count > 2).sum()),
        "free_faces_unnamed": int(((count == 1) & ~named).sum()),
        "named_faces_not_free": int(((count == 2) & named).sum()),
        "lips_unpaired": int((times != 2).sum()) if len(both) else 0,
        "nodes_unused": int(len(deck.points) - len(np.unique(deck.tets))),
    }


def _places(deck: DeckFile, side: str) -> np.ndarray:
    corners = deck.points[deck.lip(side)]
    order = np.lexsort((corners[..., 2], corners[..., 1], corners[..., 0]))
    return np.take_along_axis(corners, order[..., None], axis=1).reshape(-1, 9)


def check_sizes(gradated: Surface, sizing) -> dict:
    """Return the 5, 50 and 95 % quantiles of edge length over target far from the front.

    Far: the target is over 0.95 l_max. Junction edges have three facets or more, or lie on two planes.
    """
    facets = gradated.facets.astype(np.int64)
    halves = np.sort(np.concatenate([facets[:, [0, 1]], facets[:, [1, 2]], facets[:, [2, 0]]]), axis=1)
    kind = np.tile(gradated.kind.astype(int), 3)
    edges, inverse, count = np.unique(halves, axis=0, return_inverse=True, return_counts=True)
    spread = np.zeros((len(edges), 2))
    spread[:, 0] = np.inf
    np.minimum.at(spread[:, 0], inverse.ravel(), kind)
    np.maximum.at(spread[:, 1], inverse.ravel(), kind)
    junction = (count > 2) | (spread[:, 0] != spread[:, 1])
    ends = gradated.points[edges]
    target = sizing.at(ends.mean(axis=1))
    ratio = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) / target
    far = target > 0.95 * sizing.l_max
    named = {"far_regular": far & ~junction, "far_junction": far & junction}
    return {
        k: np.percentile(ratio[m], (5, 50, 95)).tolist() if m.sum() > 20 else None for k, m in named.items()
    }

"""Slow, plain checks of what a gradation must keep, against its input and without the product's kernels."""

import numpy as np
from exact_intersections import intersections
from plain_distances import from_edges, from_facets, samples
from plain_topology import edge_table, lines, open_edges, patches, topology

from craftmesh.types import CRACK, INTERFACE, Surface


def measure(before: Surface, after: Surface, sizing) -> dict[str, float]:
    """Return how far `after` is from `before`: distances over targets, normals, drifts, angles."""
    found = {"smallest angle": 180.0, "largest angle": 0.0}
    angles = corner_angles(after.points[after.facets])
    found["smallest angle"] = float(angles.min())
    found["largest angle"] = float(angles.max())
    found["under 12"] = float((angles.min(axis=1) < 12).mean())
    found |= _distances(before, after, sizing)
    found |= _normals(before, after)
    found["input angle"] = float(corner_angles(before.points[before.facets]).min())
    found |= volume_drifts(before, after)
    found |= _crack_distances(before, after, sizing)
    return found


def corner_angles(corners: np.ndarray) -> np.ndarray:
    """Return the (m, 3) angles in degrees of triangles (m, 3, 3)."""
    u = np.roll(corners, -1, axis=1) - corners
    v = np.roll(corners, 1, axis=1) - corners
    size = np.linalg.norm(u, axis=2) * np.linalg.norm(v, axis=2)
    return np.degrees(np.arccos(np.clip((u * v).sum(axis=2) / np.maximum(size, 1e-300), -1, 1)))


def _distances(before, after, sizing) -> dict[str, float]:
    """Return the largest distances over the target length, from the input to the result and back.

    Points inside patches to facets of the same patch, points of junction lines to any such line. The
    target is the largest one at the cell that the point lies nearest to.
    """
    old, new = lines(before), lines(after)
    found = {
        "input to lines": _over_target(from_edges, before.points[np.unique(old)], after, new, sizing),
        "lines to input": _over_target(from_edges, samples(after.points, new), before, old, sizing),
        "input to facets": 0.0,
        "facets to input": 0.0,
    }
    for rows, result in _shared(before, after):
        mine, theirs = before.facets[rows], after.facets[result]
        inner = before.points[np.setdiff1d(mine, old)]
        there = _over_target(from_facets, inner, after, theirs, sizing) if len(inner) else 0.0
        back = _over_target(from_facets, samples(after.points, theirs), before, mine, sizing)
        found["input to facets"] = max(found["input to facets"], there)
        found["facets to input"] = max(found["facets to input"], back)
    return found


def _shared(before, after) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the rows before and after of each patch that both have, the flat ones of the box left out."""
    old, new = patches(before), patches(after)
    return [(old[key], new[key]) for key in old if key in new and key[2] in (INTERFACE, CRACK)]


def _over_target(distances, at, surface, cells, sizing) -> float:
    far, where = distances(at, surface.points, cells)
    targets = sizing.at(surface.points)[cells[where]].max(axis=1)
    return float((far / np.maximum(targets, sizing.at(at))).max())


def unit_normals(points: np.ndarray, facets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return unit normals and areas."""
    vector = np.cross(*(points[facets[:, i]] - points[facets[:, 0]] for i in (1, 2)))
    size = np.linalg.norm(vector, axis=1)
    return vector / np.maximum(size, 1e-300)[:, None], 0.5 * size


def _turned(surface: Surface) -> np.ndarray:
    """Return the facets with the larger label behind each normal, crack facets as they are."""
    turned = (surface.sides[:, 0] < surface.sides[:, 1]) & (surface.kind != CRACK)
    return np.where(turned[:, None], surface.facets[:, ::-1], surface.facets)


def _ring_normals(points: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Return the unit mean normal of each facet and the facets of its patch round its corners."""
    normal, area = unit_normals(points, facets)
    at_point = np.zeros((len(points), 3))
    for i in range(3):
        np.add.at(at_point, facets[:, i], normal * area[:, None])
    mean = at_point[facets].sum(axis=1)
    return mean / np.maximum(np.linalg.norm(mean, axis=1), 1e-300)[:, None]


def _normals(before, after) -> dict[str, float]:
    """Return the largest angle of a facet to the input's mean normals: nearby, and just beside it.

    Nearby: the least angle to any facet of its patch at most its longest edge further off than the nearest.
    """
    nearby, beside, own_mean = 0.0, 0.0, 0.0
    before_facets, after_facets = _turned(before), _turned(after)
    for old, new in _shared(before, after):
        theirs, mine = before_facets[old], after_facets[new]
        mean = _ring_normals(before.points, theirs)
        centre = before.points[theirs].mean(axis=1)
        own_mean = max(
            own_mean, _degrees((unit_normals(before.points, theirs)[0] * mean).sum(axis=1).min())
        )
        own = unit_normals(after.points, mine)[0]
        corners = after.points[mine]
        middle = corners.mean(axis=1)
        reach = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1)
        cosine = own @ mean.T
        nearest = from_facets(middle, before.points, theirs)[1]
        beside = max(beside, _degrees(cosine[np.arange(len(mine)), nearest].min()))
        far = np.linalg.norm(centre[None] - middle[:, None], axis=2)
        cosine = np.where(far <= (reach + far.min(axis=1))[:, None], cosine, -1)
        nearby = max(nearby, _degrees(cosine.max(axis=1).min()))
    return {"normal nearby": nearby, "normal beside": beside, "own normals": own_mean}


def _degrees(cosine: float) -> float:
    return float(np.degrees(np.arccos(np.clip(cosine, -1, 1))))


def volumes(surface: Surface) -> dict[int, float]:
    """Return the volumes of grains and voids."""
    found = {}
    for label in np.unique(surface.sides).tolist():
        if label == 0:
            continue
        total = 0.0
        for column, turn in ((0, 1), (1, -1)):
            rows = (surface.sides[:, column] == label) & (surface.sides[:, 1 - column] != label)
            a, b, c = (surface.points[surface.facets[rows, i]] - surface.points[0] for i in range(3))
            total += turn * float((np.cross(a, b) * c).sum()) / 6
        found[label] = abs(total)
    return found


def volume_drifts(before, after) -> dict[str, float]:
    old, new = volumes(before), volumes(after)
    drift = {k: abs(new.get(k, 0.0) / v - 1) for k, v in old.items()}
    voids = [v for k, v in drift.items() if k < 0]
    return {"drift": max(v for k, v in drift.items() if k > 0), "void drift": max(voids, default=0.0)}


def front(surface: Surface) -> np.ndarray:
    """Return the edges (k, 2) on which one crack facet lies and no facet of the box or of a void."""
    edges, of = edge_table(surface.facets.astype(np.int64))
    on_crack = _facets_on(of[surface.kind == CRACK], len(edges))
    on_free = _facets_on(of[(surface.sides <= 0).any(axis=1)], len(edges))
    return edges[(on_crack == 1) & (on_free == 0)]


def ears(surface: Surface) -> int:
    """Return the number of edges inside the crack between two nodes of the front."""
    at_front = np.zeros(len(surface.points), bool)
    at_front[front(surface)] = True
    edges, of = edge_table(surface.facets)
    on_crack = _facets_on(of[surface.kind == CRACK], len(edges))
    return int((at_front[edges].all(axis=1) & (on_crack > 1)).sum())


def chords(surface: Surface) -> int:
    """Return the number of edges off the crack that join two of its nodes and run along their facets."""
    edges, of = edge_table(surface.facets)
    crack, points = surface.facets[surface.kind == CRACK], surface.points
    off = _facets_on(of[surface.kind == CRACK], len(edges)) == 0
    found = edges[off & np.isin(edges, crack).all(axis=1)]
    middles, length = (
        points[found].mean(axis=1),
        np.linalg.norm(np.diff(points[found], axis=1)[:, 0], axis=1),
    )
    at_ends = [crack[np.isin(crack, edge).any(axis=1)] for edge in found]
    near = [from_facets(middle[None], points, own)[0][0] for middle, own in zip(middles, at_ends)]
    return int((np.array(near) < 0.149 * length).sum())


def _facets_on(of: np.ndarray, count: int) -> np.ndarray:
    """Return how many of the facets with edges `of` (m, 3) lie on each of `count` edges."""
    return np.bincount(of.ravel(), minlength=count)


def _crack_distances(before, after, sizing) -> dict[str, float]:
    """Return distances over l_min: crack nodes from the input's crack, front nodes from its front, back."""
    names = ("crack to input", "input to crack", "front nodes to input", "input to front", "crack area")
    found = dict.fromkeys(names, 0.0)
    old, new = (s.facets[s.kind == CRACK] for s in (before, after))
    if not len(old) or not len(new):
        return found
    # A crack's mouth on a void follows the void's facets, so it may leave the input's crack sideways.
    mouth = after.facets[(after.kind == INTERFACE) & (after.sides <= 0).any(axis=1)]
    at = after.points[np.setdiff1d(new, mouth)]
    if len(at):
        found["crack to input"] = float(from_facets(at, before.points, old)[0].max()) / sizing.l_min
    at = before.points[np.unique(old)]
    found["input to crack"] = float(from_facets(at, after.points, new)[0].max()) / sizing.l_min
    area = [unit_normals(s.points, f)[1].sum() for s, f in ((before, old), (after, new))]
    found["crack area"] = float(area[1] / area[0] - 1)
    old, new = front(before), front(after)
    if len(old) and len(new):
        at = after.points[np.unique(new)]
        found["front nodes to input"] = float(from_edges(at, before.points, old)[0].max()) / sizing.l_min
        at = before.points[np.unique(old)]
        found["input to front"] = float(from_edges(at, after.points, new)[0].max()) / sizing.l_min
    return found


def hard_breaches(before: Surface, after: Surface) -> list[str]:
    """Return what no tolerance excuses: topology, duplicates, intersections, the box, ears, chords."""
    breaches = open_edges(after)
    if not np.isfinite(after.points).all():
        return ["points are not finite"]
    if len(np.unique(after.facets)) != len(after.points):
        breaches.append("points belong to no facet")
    if len(np.unique(np.sort(after.facets, axis=1), axis=0)) != len(after.facets):
        breaches.append("duplicate facets")
    if (unit_normals(after.points, after.facets)[1] <= 0).any():
        breaches.append("facets without area")
    breaches += topology_breaches(before, after) + box_breaches(before, after)
    if ears(after) > ears(before):
        breaches.append(f"{ears(after)} crack edges join two front nodes, {ears(before)} before")
    if chords(after) > chords(before):
        breaches.append(f"{chords(after)} edges run along the crack, {chords(before)} before")
    met = intersections(after.points, after.facets)
    if met:
        breaches.append(f"{len(met)} pairs intersect, first {met[0]}")
    return breaches


def topology_breaches(before: Surface, after: Surface) -> list[str]:
    """Return the labels and contacts that have other Euler numbers or parts than before.

    Parts of a contact that touched in a single point may come apart there: its Euler number then rises.
    """
    breaches = []
    was, now = topology(before), topology(after)
    for key in sorted(was.keys() | now.keys(), key=str):
        old, new = was.get(key, (None, None)), now.get(key, (None, None))
        apart = key[0] == "patch" and old[1] == new[1] and new[0] > old[0]
        if old != new and not apart:
            breaches.append(f"topology of {key}: {old} -> {new}")
    return breaches


def box_breaches(before: Surface, after: Surface) -> list[str]:
    """Return where the planes of the box are no longer exact or not covered once, or corners are gone."""
    breaches = []
    for kind in np.unique(before.kind[(before.kind != INTERFACE) & (before.kind != CRACK)]).tolist():
        axis, upper = divmod(kind - 1, 2)
        old, new = before.facets[before.kind == kind], after.facets[after.kind == kind]
        level = before.points[old[0, 0], axis]
        if not len(new) or (after.points[new][:, :, axis] != level).any():
            breaches.append(f"box plane {kind} has facets off it")
            continue
        if (after.points[:, axis] > level if upper else after.points[:, axis] < level).any():
            breaches.append(f"points beyond box plane {kind}")
        # The same area, never doubled: signed and unsigned sums agree with the input's.
        areas = [unit_normals(s.points, f) for s, f in ((before, old), (after, new))]
        signed = [
            abs((n[:, axis] * a * _outward(s, kind)).sum()) for (n, a), s in zip(areas, (before, after))
        ]
        whole = before.sides[before.kind == kind]
        if (whole.max(axis=1) > 0).all() and not _open(before):
            for total in (areas[1][1].sum(), signed[1]):
                if abs(total - areas[0][1].sum()) > 1e-9 * areas[0][1].sum():
                    breaches.append(f"box plane {kind} covers {total} instead of {areas[0][1].sum()}")
    corners = [_box_corners(s) for s in (before, after)]
    if corners[0] != corners[1]:
        breaches.append("corners of the box are gone")
    return breaches


def _outward(surface: Surface, kind: int) -> np.ndarray:
    return np.where(surface.sides[surface.kind == kind, 0] > 0, 1, -1)


def _open(surface: Surface) -> bool:
    return bool(((surface.sides == 0).any(axis=1) & (surface.kind == INTERFACE)).any())


def _box_corners(surface: Surface) -> set[tuple]:
    low, high = surface.points.min(axis=0), surface.points.max(axis=0)
    at = ((surface.points == low) | (surface.points == high)).all(axis=1)
    return set(map(tuple, surface.points[at].tolist()))

"""Slow, plain checks of what a gradation must keep, against its input and without the product's kernels."""

from fractions import Fraction

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from craftmesh.types import CRACK, INTERFACE, Surface

# --- patches, lines, topology -------------------------------------------------------------------


def edge_table(facets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the edges (e, 2), lower id first, and of each facet corner the edge that starts there."""
    directed = np.stack([facets, np.roll(facets, -1, axis=1)], axis=2).reshape(-1, 2).astype(np.int64)
    width = int(directed.max()) + 1
    keys, of = np.unique(directed.min(axis=1) * width + directed.max(axis=1), return_inverse=True)
    return np.stack([keys // width, keys % width], axis=1), of.reshape(-1, 3)


def patch_keys(surface: Surface) -> list[tuple]:
    """Return per facet its pair of sides, the larger first, and its kind."""
    high, low = surface.sides.max(axis=1), surface.sides.min(axis=1)
    return list(zip(high.tolist(), low.tolist(), surface.kind.tolist()))


def patches(surface: Surface) -> dict[tuple, np.ndarray]:
    """Return patch key -> rows of its facets."""
    rows = {}
    for row, key in enumerate(patch_keys(surface)):
        rows.setdefault(key, []).append(row)
    return {key: np.array(found) for key, found in rows.items()}


def lines(surface: Surface) -> np.ndarray:
    """Return the feature edges (k, 2): not between two facets of one patch."""
    edges, of = edge_table(surface.facets)
    number = {key: i for i, key in enumerate(dict.fromkeys(patch_keys(surface)))}
    patch = np.repeat([number[key] for key in patch_keys(surface)], 3)
    low, high = np.full(len(edges), len(number)), np.full(len(edges), -1)
    np.minimum.at(low, of.ravel(), patch)
    np.maximum.at(high, of.ravel(), patch)
    return edges[(np.bincount(of.ravel()) != 2) | (low != high)]


def components(links: np.ndarray, nodes: np.ndarray) -> int:
    """Return the number of components of the graph with edges `links` (k, 2) on `nodes`."""
    size = int(nodes.max(initial=-1)) + 1
    graph = coo_matrix((np.ones(len(links), np.int8), (links[:, 0], links[:, 1])), shape=(size, size))
    return len(np.unique(connected_components(graph, directed=False)[1][nodes]))


def euler_number(facets: np.ndarray) -> int:
    return len(np.unique(facets)) - len(edge_table(facets)[0]) + len(facets)


def sheets(facets: np.ndarray) -> int:
    """Return how many parts facets joined over edges make."""
    edges, of = edge_table(facets)
    rows = np.repeat(np.arange(len(facets)), 3)
    links = np.stack([rows, len(facets) + of.ravel()], axis=1)
    return components(links, np.arange(len(facets) + len(edges)))


def topology(surface: Surface) -> dict[tuple, tuple]:
    """Return Euler number and parts of each label's boundary and of each patch (a contact)."""
    facets = surface.facets.astype(np.int64)
    found = {}
    bounds = surface.sides[:, 0] != surface.sides[:, 1]
    for label in np.unique(surface.sides).tolist():
        mine = facets[(surface.sides == label).any(axis=1) & bounds]
        if len(mine):
            found["label", label] = euler_number(mine), sheets(mine)
    for key, rows in patches(surface).items():
        found["patch", key] = euler_number(facets[rows]), sheets(facets[rows])
    return found


def open_edges(surface: Surface) -> list[str]:
    """Return the labels round which a directed edge lacks its partner."""
    breaches = []
    facets = surface.facets.astype(np.int64)
    bounds = surface.sides[:, 0] != surface.sides[:, 1]
    for label in np.unique(surface.sides).tolist():
        behind = facets[bounds & (surface.sides[:, 0] == label)]
        ahead = facets[bounds & (surface.sides[:, 1] == label)][:, ::-1]
        mine = np.concatenate([behind, ahead])
        balance = {}
        for a, b in np.stack([mine, np.roll(mine, -1, axis=1)], axis=2).reshape(-1, 2).tolist():
            key, turn = ((a, b), 1) if a < b else ((b, a), -1)
            balance[key] = balance.get(key, 0) + turn
        count = sum(v != 0 for v in balance.values())
        if count:
            breaches.append(f"label {label} has {count} open edges")
    return breaches


# --- distances ----------------------------------------------------------------------------------


def nearest_on_segments(at, p, q) -> np.ndarray:
    """Return the nearest places (n, 3) to points `at` (n, 3) on the segments p-q (n, 3), one by one."""
    d = q - p
    t = ((at - p) * d).sum(axis=1) / np.maximum((d * d).sum(axis=1), 1e-300)
    return p + np.clip(t, 0, 1)[:, None] * d


def segment_distances(at, p, q) -> np.ndarray:
    """Return the (n,) distances of points from segments, one by one."""
    return np.linalg.norm(at - nearest_on_segments(at, p, q), axis=1)


def triangle_distances(at: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return the (n,) distances of points `at` (n, 3) from triangles (n, 3, 3), one by one."""
    least = np.full(len(at), np.inf)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inside = np.ones(len(at), bool)
    for i in range(3):
        p, q = corners[:, i], corners[:, (i + 1) % 3]
        least = np.minimum(least, segment_distances(at, p, q))
        inside &= (np.cross(q - p, at - p) * normal).sum(axis=1) >= 0
    length = np.maximum(np.linalg.norm(normal, axis=1), 1e-300)
    height = np.abs(((at - corners[:, 0]) * normal).sum(axis=1)) / length
    return np.where(inside, np.minimum(least, height), least)


def _nearest(distances, at: np.ndarray, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the least distance of each point from cells (k, c, 3), and the nearest cell.

    No cell is nearer than its centre's distance less its radius, which leaves few to look at.
    """
    centre = corners.mean(axis=1)
    radius = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1)
    reach = cKDTree(corners.reshape(-1, 3)).query(at)[0] + radius.max()
    around = cKDTree(centre).query_ball_point(at, reach * (1 + 1e-9))
    point = np.repeat(np.arange(len(at)), [len(cells) for cells in around])
    cell = np.concatenate([np.asarray(cells, np.int64) for cells in around])
    found = distances(at[point], corners[cell])
    order = np.lexsort((cell, found, point))
    first = order[np.searchsorted(point[order], np.arange(len(at)))]
    return found[first], cell[first]


def from_facets(at: np.ndarray, points: np.ndarray, facets: np.ndarray):
    """Return the distances of `at` from a facet set, and the nearest facet."""
    return _nearest(triangle_distances, at, points[facets])


def from_edges(at: np.ndarray, points: np.ndarray, edges: np.ndarray):
    """Return the distances of `at` from an edge set, and the nearest edge."""
    return _nearest(lambda at, ends: segment_distances(at, ends[:, 0], ends[:, 1]), at, points[edges])


def samples(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Return corners, middles of edges and centroids of triangles or segments."""
    corners = points[cells]
    if cells.shape[1] == 2:
        return np.concatenate([points[np.unique(cells)], corners.mean(axis=1)])
    middles = 0.5 * (corners + np.roll(corners, -1, axis=1)).reshape(-1, 3)
    return np.concatenate([points[np.unique(cells)], middles, corners.mean(axis=1)])


# --- intersections ------------------------------------------------------------------------------


def close_pairs(points: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Return the pairs (k, 2) of facets whose boxes along the axes meet."""
    corners = points[facets]
    low, high = corners.min(axis=1), corners.max(axis=1)
    order = np.argsort(low[:, 0], kind="stable")
    last = np.searchsorted(low[order, 0], high[order, 0], side="right")
    count = last - np.arange(len(order)) - 1
    first = np.repeat(np.arange(len(order)), count)
    second = first + 1 + np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    i, j = order[first], order[second]
    meet = ((low[i] <= high[j]) & (low[j] <= high[i])).all(axis=1)
    return np.stack([i[meet], j[meet]], axis=1)


def intersections(points: np.ndarray, facets: np.ndarray) -> list[tuple[int, int]]:
    """Return the pairs of facets that meet in more than the corners and edges they share, exactly.

    Pairs that a plane parts by more than rounding errors are passed over; the rest is decided in
    rational numbers.
    """
    pairs = close_pairs(points, facets)
    undecided = pairs[~_parted(points, facets, pairs)]
    place = [[Fraction(float(x)) for x in point] for point in points]
    return [(int(i), int(j)) for i, j in undecided if _meet(place, facets[i].tolist(), facets[j].tolist())]


def _parted(points, facets, pairs) -> np.ndarray:
    """Return (k,) bool: pairs that a plane surely parts, the corners they share lying on it."""
    f, g = facets[pairs[:, 0]], facets[pairs[:, 1]]
    same = f[:, :, None] == g[:, None, :]
    shared_f, shared_g = same.any(axis=2), same.any(axis=1)
    joined = shared_f.any(axis=1)
    rows = np.arange(len(pairs))
    origin = points[f[rows, shared_f.argmax(axis=1)]]
    p, q = points[f] - origin[:, None], points[g] - origin[:, None]
    scale = np.maximum(np.abs(p).max(axis=(1, 2)), np.abs(q).max(axis=(1, 2)))
    p, q = p / scale[:, None, None], q / scale[:, None, None]
    parted, twins = np.zeros(len(pairs), bool), shared_f.all(axis=1)
    for number in range(17):
        left = np.flatnonzero(~parted)
        axis = _axis(number, p[left], q[left])
        length = np.linalg.norm(axis, axis=1)
        axis /= np.maximum(length, 1e-300)[:, None]
        x, y = (np.einsum("ijk,ik->ij", corners[left], axis) for corners in (p, q))
        on_f, on_g = shared_f[left], shared_g[left]
        sure = (length > 1e-6) & (np.where(on_f, np.abs(x), 0.0).max(axis=1) <= 1e-13)
        apart = np.maximum(y.min(axis=1) - x.max(axis=1), x.min(axis=1) - y.max(axis=1)) > 1e-9
        beside = _beside(x, y, on_f) | _beside(y, x, on_g)
        parted[left] = sure & np.where(joined[left], beside, apart)
    return parted & ~twins


def _axis(number: int, p, q) -> np.ndarray:
    """Return one of the normals of planes that may part triangles p and q (k, 3, 3)."""
    e, h = np.roll(p, -1, axis=1) - p, np.roll(q, -1, axis=1) - q
    if number >= 8:
        return np.cross(e[:, (number - 8) // 3], h[:, (number - 8) % 3])
    side = (e, h)[number % 2]
    normal = np.cross(side[:, 0], side[:, 1])
    return normal if number < 2 else np.cross(normal, side[:, number // 2 - 1])


def _beside(x, y, shared) -> np.ndarray:
    """Tell whether the corners of x that are not `shared` are all above 0 and none of y is, or below."""
    above = np.where(shared, np.inf, x).min(axis=1) > 1e-6
    below = np.where(shared, -np.inf, x).max(axis=1) < -1e-6
    return above & (y.max(axis=1) <= 1e-13) | below & (y.min(axis=1) >= -1e-13)


def _meet(place, f, g) -> bool:
    """Tell whether facets f and g meet beyond what they share; coordinates are rational."""
    shared = [v for v in f if v in g]
    p, q = [place[v] for v in f], [place[v] for v in g]
    if len(shared) == 3:
        return True
    if len(shared) == 2:
        a, b = (place[v] for v in shared)
        c = place[next(v for v in f if v not in shared)]
        d = place[next(v for v in g if v not in shared)]
        normal = _cross(_less(b, a), _less(c, a))
        if not any(normal):
            return True
        along = _cross(normal, _less(b, a))
        return _dot(normal, _less(d, a)) == 0 and _dot(along, _less(d, a)) > 0
    if len(shared) == 1:
        across_f = [place[v] for v in f if v not in shared]
        across_g = [place[v] for v in g if v not in shared]
        return _crosses(*across_f, q) or _crosses(*across_g, p)
    return any(_crosses(p[i], p[i - 1], q) or _crosses(q[i], q[i - 1], p) for i in range(3))


def _less(a, b):
    return [a[0] - b[0], a[1] - b[1], a[2] - b[2]]


def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _crosses(a, b, triangle) -> bool:
    """Tell whether segment a-b meets the closed triangle."""
    normal = _cross(_less(triangle[1], triangle[0]), _less(triangle[2], triangle[0]))
    s, t = _dot(normal, _less(a, triangle[0])), _dot(normal, _less(b, triangle[0]))
    if s * t > 0:
        return False
    if s == 0 and t == 0:
        return _crosses_flat(a, b, triangle, normal)
    part = s / (s - t)
    x = [a[k] + part * (b[k] - a[k]) for k in range(3)]
    return _holds(x, triangle, normal)


def _holds(x, triangle, normal) -> bool:
    turns = [
        _dot(normal, _cross(_less(triangle[(i + 1) % 3], triangle[i]), _less(x, triangle[i])))
        for i in range(3)
    ]
    return min(turns) >= 0


def _crosses_flat(a, b, triangle, normal) -> bool:
    if not any(normal):
        return True
    if _holds(a, triangle, normal) or _holds(b, triangle, normal):
        return True
    axis = max(range(3), key=lambda k: abs(normal[k]))
    i, j = [k for k in range(3) if k != axis]

    def turn(p, q, r):
        return (q[i] - p[i]) * (r[j] - p[j]) - (q[j] - p[j]) * (r[i] - p[i])

    for k in range(3):
        c, d = triangle[k], triangle[(k + 1) % 3]
        if turn(a, b, c) * turn(a, b, d) <= 0 and turn(c, d, a) * turn(c, d, b) <= 0:
            if any((turn(a, b, c), turn(a, b, d), turn(c, d, a), turn(c, d, b))):
                return True
    return False


# --- the guards ---------------------------------------------------------------------------------


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
    """Return the edges (k, 2) that belong to one crack facet and no other facet."""
    edges, of = edge_table(surface.facets.astype(np.int64))
    count = np.bincount(of.ravel(), minlength=len(edges))
    mine = np.unique(of[surface.kind == CRACK])
    return edges[mine[count[mine] == 1]]


def ears(surface: Surface) -> int:
    """Return the number of crack edges, other than front edges, between two nodes of the front."""
    at_front = np.zeros(len(surface.points), bool)
    at_front[front(surface)] = True
    edges, of = edge_table(surface.facets)
    on_crack = np.zeros(len(edges), bool)
    on_crack[of[surface.kind == CRACK]] = True
    return int((at_front[edges].all(axis=1) & on_crack & (np.bincount(of.ravel()) > 1)).sum())


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
    """Return what no tolerance excuses: topology, duplicates, intersections, the box, ears."""
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

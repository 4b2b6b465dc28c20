"""The guard of gaps: no change makes a gap narrower than its limit and than all at its star before.

A gap is where a vertex stands over a facet, or where two edges without a common vertex cross: a tetrahedron
between them is as flat as the gap. A vertex that another facet joins to one of the facet's edges makes a
wedge with it and no gap (wedge_guard).
"""

import numpy as np

from craftmesh.gradation.kernels.facet_grid import list_hits
from craftmesh.gradation.kernels.gaps import (
    crossing_width,
    edge_of_area,
    height_over,
    is_farther,
    is_inside,
    is_on_one_side,
    may_overlap,
    share_edge,
    unit_normal,
)
from craftmesh.gradation.kernels.intersections import set_planes
from craftmesh.gradation.kernels.rings import has_corner
from craftmesh.gradation.kernels.star import look_around, old_facet
from craftmesh.jit import kernel, lean_kernel

# No gap as narrow as the limits was found.
WIDE = 1.0
# A gap whose facets move within their planes counts as no narrower.
ROUNDING = 1e-9
# The cosine of the wedges (60 degrees) beyond which facets that go on beside a star come near its own.
SHARP = 0.5


@lean_kernel
def narrows_gap(state, grid, star, near, reach, share):
    """Tell whether a gap at the star's new facets is under the share and narrower than all before.

    near, reach: the candidates that look_around has listed for the new facets. share: the least width.
    """
    moving = star.tip if star.tip != star.vertex else np.int64(-1)
    tips = (star.tip, star.tip)
    after = _narrowest(state, grid, star, near, reach, state.star_corners, star.moved, tips, moving, share)
    return after < WIDE and after < _gap_before(state, grid, star, share) * (1.0 - ROUNDING)


@lean_kernel
def _gap_before(state, grid, star, share):
    """Return the narrowest gap at the star's old facets over its share, or WIDE."""
    rows = state.old_corners
    count = star.moved + star.dying
    for i in range(count):
        f = old_facet(state, star, i)
        for k in range(3):
            rows[i, k] = state.facets[f, k]
    near, reach = look_around(state, grid, star, rows, count, share)
    if near < 0:
        return 0.0
    moving = star.vertex if star.tip != star.vertex else star.gone
    turned = state.star_corners[0, 1] if moving < 0 else moving
    tips = (turned, turned if star.gone < 0 else star.gone)
    least = _narrowest(state, grid, star, near, reach, rows, count, tips, moving, share)
    if star.gone >= 0 and moving != star.gone:
        least = min(least, _under_vertex(state, grid, near, star.gone, rows, count, reach, share))
    return least


@kernel
def _narrowest(state, grid, star, near, reach, rows, count, tips, moving, share):
    """Return the narrowest gap at the facets rows[:count] over its share, or WIDE.

    Edges with one of the `tips` count; `moving` is a vertex that is looked for over other facets, or -1.
    """
    sharp = state.sharpest[0] > SHARP
    if not sharp:
        near = _keep_facing(state, grid, star, near)
        if near == 0:
            return WIDE
    least = WIDE
    if moving >= 0:
        least = _under_vertex(state, grid, near, moving, rows, count, reach, share)
    planes = np.empty((4, 5))
    for i in range(count):
        if sharp:
            a, b, c = rows[i]
            normal = unit_normal(state.points, a, b, c)
            ready = False
            for j in range(i):
                if share_edge(rows, j, a, b, c) or is_on_one_side(
                    state.points, normal, rows[i], rows[j], reach
                ):
                    continue
                if not ready:
                    set_planes(state.points, rows[i], planes)
                    ready = True
                if may_overlap(state.points, planes, a, b, c, rows, j, reach):
                    least = min(
                        least, _between(state, star, rows, count, rows[i], rows[j], planes, tips, share)
                    )
        least = min(
            least, _to_candidates(state, grid, star, near, rows, count, i, planes, tips, reach, share)
        )
    return least


@lean_kernel
def _keep_facing(state, grid, star, near):
    """Drop the candidates that go on beside the star's facets; return how many are left.

    They have the patch of one of them and look the same way: on the far side of a grain the facets of one
    patch look the other way, as their references do.
    """
    patch, reference, listed = state.patch, state.reference, state.patch_facet
    candidate, bounds = grid.candidate, grid.bounds
    count = _list_patches(state, star)
    left = 0
    for n in range(near):
        f = candidate[n]
        along = -1.0
        for k in range(count):
            s = listed[k]
            if patch[s] == patch[f]:
                along = reference[f, 0] * reference[s, 0] + reference[f, 1] * reference[s, 1]
                along += reference[f, 2] * reference[s, 2]
                break
        if along <= 0.0:
            candidate[left] = f
            for k in range(6):
                bounds[k, left] = bounds[k, n]
            left += 1
    return left


@lean_kernel
def _list_patches(state, star):
    """List one of the star's facets for each of their patches in state.patch_facet; return how many."""
    patch, listed = state.patch, state.patch_facet
    count = 0
    for i in range(star.moved + star.dying):
        f = old_facet(state, star, i)
        k = 0
        while k < count and patch[listed[k]] != patch[f]:
            k += 1
        if k == count:
            listed[count] = f
            count += 1
    return count


@lean_kernel
def _to_candidates(state, grid, star, near, rows, count, i, planes, tips, reach, share):
    """Return the narrowest gap between the facet rows[i] and the candidates, over its share."""
    corners = rows[i]
    points, facets = state.points, state.facets
    a, b, c = corners
    least = WIDE
    normal = unit_normal(points, a, b, c)
    ready = False
    for n in range(list_hits(grid, near, points, a, b, c, reach)):
        f = grid.hits[n]
        if share_edge(facets, f, a, b, c):
            continue
        if is_on_one_side(points, normal, corners, facets[f], reach):
            continue
        if not ready:
            set_planes(points, corners, planes)
            ready = True
        if may_overlap(points, planes, a, b, c, facets, f, reach):
            least = min(least, _between(state, star, rows, count, corners, facets[f], planes, tips, share))
    return least


@lean_kernel
def _between(state, star, rows, count, corners, other, planes, tips, share):
    """Return the narrowest gap between a facet of these corners and another one, over its share.

    A gap is from a corner of the other one, or from one of its edges to one that has a tip.
    """
    points = state.points
    least = WIDE
    a, b, c = corners
    for k in range(3):
        v = other[k]
        if v != a and v != b and v != c and is_inside(points, planes, v):
            gap = abs(height_over(points, planes, 0, v)) / (share * edge_of_area(points, a, b, c))
            if gap < least and not _makes_hinge(state, star, v, a, b, c):
                least = gap
    for i in range(3):
        p = corners[i]
        q = corners[(i + 1) % 3]
        if p == tips[0] or q == tips[0] or p == tips[1] or q == tips[1]:
            for k in range(3):
                u = other[k]
                v = other[(k + 1) % 3]
                if u != p and u != q and v != p and v != q:
                    gap = crossing_width(points, p, q, u, v) / share
                    if gap < least and not _on_hinge(state, rows, count, p, q, u, v):
                        least = gap
    return least


@lean_kernel
def _on_hinge(state, rows, count, p, q, u, v):
    """Tell whether two facets on a common edge hold the edges (p, q) and (u, v): these make a wedge."""
    for x, y in ((p, u), (p, v), (q, u), (q, v)):
        if _is_facet(state, rows, count, y, p, q) and _is_facet(state, rows, count, x, u, v):
            return True
    return False


@lean_kernel
def _is_facet(state, rows, count, a, b, c):
    """Tell whether the facet (a, b, c) is among the rows[:count], or in the surface."""
    for i in range(count):
        if has_corner(rows, i, a) and has_corner(rows, i, b) and has_corner(rows, i, c):
            return True
    d = state.first[a]
    while d >= 0:
        if has_corner(state.facets, d // 3, b) and has_corner(state.facets, d // 3, c):
            return True
        d = state.after[d]
    return False


@lean_kernel
def _makes_hinge(state, star, w, a, b, c):
    """Tell whether a facet, old or new, joins the vertex `w` to an edge of facet (a, b, c)."""
    d = state.first[w]
    while d >= 0:
        common = 0
        for k in range(1, 3):
            u = state.facets[d // 3, (d + k) % 3]
            if u == star.vertex or u == star.gone:
                u = star.tip
            for corner in (a, b, c):
                if corner == star.vertex or corner == star.gone:
                    corner = star.tip
                common += u == corner
        if common >= 2:
            return True
        d = state.after[d]
    return False


@kernel
def _under_vertex(state, grid, near, moving, rows, count, reach, share):
    """Return the least height of the vertex `moving` over a candidate, over its share."""
    points, bounds = state.points, grid.bounds
    x, y, z = points[moving]
    least = WIDE
    planes = np.empty((4, 5))
    for n in range(near):
        if x < bounds[0, n] - reach or x > bounds[1, n] + reach or y < bounds[2, n] - reach:
            continue
        if y > bounds[3, n] + reach or z < bounds[4, n] - reach or z > bounds[5, n] + reach:
            continue
        a, b, c = state.facets[grid.candidate[n]]
        if a == moving or b == moving or c == moving:
            continue
        if is_farther(points, a, b, c, moving, share * least):
            continue
        set_planes(points, state.facets[grid.candidate[n]], planes)
        if is_inside(points, planes, moving):
            gap = abs(height_over(points, planes, 0, moving)) / (share * edge_of_area(points, a, b, c))
            if gap < least and not _hinge_among(rows, count, moving, a, b, c):
                least = gap
    return least


@lean_kernel
def _hinge_among(rows, count, moving, a, b, c):
    """Tell whether one of the facets rows[:count] joins the vertex `moving` to an edge of (a, b, c)."""
    for i in range(count):
        common = 0
        has = False
        for k in range(3):
            u = rows[i, k]
            has = has or u == moving
            common += u == a or u == b or u == c
        if has and common >= 2:
            return True
    return False

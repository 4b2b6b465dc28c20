"""The facets between the labels of one cell of the dual grid.

The segments on the cell's faces (`cell_faces`) join edge points, on cell edges whose ends have different
labels, and face points, on some cell faces with three or four labels. A chain is a sequence of segments
through edge points from one face point to another. A cell point is a new point inside the cell. Each
connected component of face segments gets its own facets:

    no face point (a loop of one label pair)    | best triangulation of the loop, else a fan;
                                                | a fan for one of two long loops
    two face points joined by three chains      | a junction edge between them closes each chain
    any other component                         | a cone from a cell point, after `cell_wedges`
"""

from collections import namedtuple

import numpy as np

from craftmesh.jit import lean_kernel
from craftmesh.remeshing.kernels.cell_faces import face_segments, triangulate
from craftmesh.remeshing.kernels.cell_tables import FIRST_CELL_POINT, FIRST_FACE_POINT, POINT_AT
from craftmesh.remeshing.kernels.cell_wedges import cone, cut_tied_wedge, middle_of

MAX_FACETS = 256
LONG_LOOP = 6

# segments (64, 4): of the cell, rows as in `cell_faces`; link (64, 4): of one component; sheets (256, 5):
# three local points, labels behind and ahead; at: positions of the local points; group, after: component
# and outgoing segment of each point. The others are scratch.
Scratch = namedtuple(
    "Scratch", "segments link sheets at group after polygon triangles cost split stack used ring across"
)


def new_scratch() -> Scratch:
    """Return the work arrays of one sweep over all cells."""
    integers = {
        "segments": (64, 4),
        "link": (64, 4),
        "sheets": (MAX_FACETS, 5),
        "group": FIRST_CELL_POINT,
        "after": FIRST_CELL_POINT,
        "polygon": 16,
        "triangles": (16, 3),
        "split": (16, 16),
        "stack": (32, 2),
        "ring": 64,
        "across": 64,
    }
    arrays = {name: np.zeros(shape, np.int64) for name, shape in integers.items()}
    return Scratch(at=POINT_AT.copy(), cost=np.zeros((16, 16)), used=np.zeros(64, bool), **arrays)


@lean_kernel
def _find_components(segments, count, group, after):
    """Fill `group` with the lowest connected point and `after` with the outgoing segment of each point."""
    for p in range(FIRST_CELL_POINT):
        group[p] = p
        after[p] = -1
    changed = True
    while changed:
        changed = False
        for s in range(count):
            a, b = group[segments[s, 0]], group[segments[s, 1]]
            if a != b:
                group[segments[s, 0]] = group[segments[s, 1]] = min(a, b)
                changed = True
    for s in range(count):
        after[segments[s, 0]] = s


@lean_kernel
def _append_polygon(triangles, number, right, left, sheets, count):
    """Append `number` triangles with the labels `right` behind and `left` ahead; return the new count."""
    for t in range(number):
        for corner in range(3):
            sheets[count, corner] = triangles[t, corner]
        sheets[count, 3], sheets[count, 4] = right, left
        count += 1
    return count


@lean_kernel
def _span_loop(link, size, others, new, scratch, count):
    """Fill a loop of one label pair; return the new count of facets and the next free cell point.

    link, size: the loop's segments; new: next free cell point, which a fan uses. others: count of segments
    in other components; two long loops, both with diagonals, would meet in the middle of the cell.
    """
    polygon, triangles, at = scratch.polygon, scratch.triangles, scratch.at
    p = link[0, 0]
    for i in range(size):
        polygon[i] = p
        p = scratch.segments[scratch.after[p], 1]
    right, left = link[0, 2], link[0, 3]
    number = 0
    if size < LONG_LOOP or others < LONG_LOOP:
        number = triangulate(polygon, size, at, scratch, triangles)
    if number:
        return _append_polygon(triangles, number, right, left, scratch.sheets, count), new
    middle_of(link, size, at, new)
    return cone(link, size, new, scratch.sheets, count), new + 1


@lean_kernel
def _span_junction(link, size, scratch, count):
    """Join two face points by an edge that closes the three chains between them.

    Return the new count of facets, or -1 if there are not three chains or one cannot be triangulated.
    """
    polygon, triangles = scratch.polygon, scratch.triangles
    chains = 0
    for s in range(size):
        if link[s, 0] < FIRST_FACE_POINT:
            continue
        polygon[0] = link[s, 0]
        n, p = 1, link[s, 1]
        while p < FIRST_FACE_POINT:
            polygon[n] = p
            n += 1
            p = scratch.segments[scratch.after[p], 1]
        if p == polygon[0]:
            return -1
        polygon[n] = p
        number = triangulate(polygon, n + 1, scratch.at, scratch, triangles)
        if number == 0:
            return -1
        count = _append_polygon(triangles, number, link[s, 2], link[s, 3], scratch.sheets, count)
        chains += 1
    return count if chains == 3 else -1


@lean_kernel
def _span_cone(link, size, new, is_first, scratch, count):
    """Span a cone from cell point `new` over a link, the segments around the point.

    Parts (wedges) of a grain that would touch itself at the point first get cell points of their own.
    is_first: the cone is the cell's first, so its point is the cell's centre, not the link's middle. Return
    the new count of facets and the next free cell point.
    """
    at, apex = scratch.at, new
    at[apex] = 0.5
    if not is_first:
        middle_of(link, size, at, apex)
    new += 1
    tied = True
    while tied:
        tied, size, count = cut_tied_wedge(link, size, apex, new, at, scratch.sheets, count, scratch)
        new += tied
    return cone(link, size, apex, scratch.sheets, count), new


@lean_kernel
def _component(segments, count, group, root, link):
    """Copy the segments of component `root` to `link`; return the numbers of segments and face points."""
    size = face_points = 0
    for s in range(count):
        if group[segments[s, 0]] == root:
            for column in range(4):
                link[size, column] = segments[s, column]
            size += 1
    if size:
        for p in range(FIRST_FACE_POINT, FIRST_CELL_POINT):
            face_points += group[p] == root
    return size, face_points


@lean_kernel
def cell_sheets(labels, scratch):
    """Fill scratch.sheets with the facets of a cell with corner labels (8,); return their number.

    A row is three local points (positions in scratch.at), the label behind and the label ahead, with
    behind < ahead. Labels below 6 are the outside labels x-, x+, y-, y+, z-, z+.
    """
    segments, link, group = scratch.segments, scratch.link, scratch.group
    total = 0
    for face in range(6):
        total = face_segments(labels, face, segments, total)
    _find_components(segments, total, group, scratch.after)
    count, new, cones = 0, FIRST_CELL_POINT, 0
    for root in range(FIRST_CELL_POINT):
        size, face_points = _component(segments, total, group, root, link)
        if size == 0:
            continue
        if face_points == 0:
            count, new = _span_loop(link, size, total - size, new, scratch, count)
            continue
        spanned = _span_junction(link, size, scratch, count) if face_points == 2 else -1
        if spanned < 0:
            spanned, new = _span_cone(link, size, new, cones == 0, scratch, count)
            cones += 1
        count = spanned
    return count

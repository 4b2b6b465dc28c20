"""Words for front nodes whose parameters deserve a second look."""

import numpy as np

from craftmesh.fracture.fit import HALF_WIDTH, FrontLine
from craftmesh.fracture.options import LEAST_RADIUS
from craftmesh.fracture.segments import Segments
from craftmesh.mesh.front_frames import Front
from craftmesh.mesh.front_places import edges_between_materials, meets_boundary
from craftmesh.types import TetMesh

# Errors over so much of the largest K of the front are flagged, some ten times those of exact cases, and so
# are lips that overlap: K_I under 0 by more than that of |K|.
LARGE = 0.05


def flags_of(
    mesh: TetMesh,
    front: Front,
    line: FrontLine,
    segments: Segments,
    radius: np.ndarray,
    k: np.ndarray,
    error: np.ndarray,
    material: np.ndarray,
    touch: np.ndarray,
) -> np.ndarray:
    """Return for each corner node of a front its words joined by +, empty where all is well.

    end: of an open front. pierce: grains meet in the node. limit: the material changes here, and values
    are the mean of both sides' limits. short: on a segment shorter than a test is wide. narrow: there is no
    room for three edges of radius. error: that of K is over 5 % of the largest K of the front. closed: the
    lips touch at the node, touch (k,), or K_I is negative and more than 5 % of |K|: they would overlap.
    interface: elements of several materials (m,), numbers by element, lie round an edge of the front at the
    node, as where the crack runs in a grain boundary; K is then that of the fields of one of them, not of a
    crack between two crystals.
    """
    count = len(line.s)
    size = np.sqrt((k * k).sum(axis=1))
    ends = np.zeros(count, bool)
    if not front.closed:
        ends[[0, -1]] = True
    limit, short = np.zeros(count, bool), np.zeros(count, bool)
    for segment, length in enumerate(segments.length):
        offset = line.s - segments.start[segment]
        offset = np.mod(offset, line.total) if front.closed else offset
        limit |= (np.abs(offset) < 1e-9 * length) & ~ends & ~np.array(segments.is_ring)
        inside = (offset >= 0) & (offset <= length)
        short |= inside & (length < HALF_WIDTH * line.sizes) & ~np.array(segments.is_ring)
    words = {
        "end": ends,
        "pierce": meets_boundary(mesh, front.corners),
        "limit": limit,
        "short": short,
        "narrow": radius < (LEAST_RADIUS + 0.5) * line.sizes * (1 - 1e-9),
        "error": error > LARGE * np.abs(k).max(),
        "closed": touch | (k[:, 0] < -LARGE * size),
        "interface": _at_interface(mesh, front, material),
    }
    return np.array(
        ["+".join(word for word, at in words.items() if at[row]) for row in range(count)], object
    )


def _at_interface(mesh: TetMesh, front: Front, material: np.ndarray) -> np.ndarray:
    """Return which corner nodes (k,) are ends of an edge of the front between several materials."""
    tails = front.corners if front.closed else front.corners[:-1]
    heads = np.roll(front.corners, -1)[: len(tails)]
    between = edges_between_materials(mesh, tails, heads, material)
    return np.isin(front.corners, np.concatenate([tails[between], heads[between]]))

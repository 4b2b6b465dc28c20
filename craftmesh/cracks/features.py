"""The lines of a crack that come near to something: its kinks and its mouths; its fronts it has itself."""

import numpy as np

from craftmesh.cracks.height_parts import MOST_PARTS, kinks_of
from craftmesh.cracks.sheets import sheets
from craftmesh.surface.measure import meets_box
from craftmesh.types import Crack

Face = tuple[int, int]  # of the box: the axis across it, and 1 for the upper one


def kink_edges(crack: Crack) -> np.ndarray:
    """Return the edges (k, 2, 3) at which a crack has kinks (`height_parts`), none of a rough sheet."""
    found = [np.zeros((0, 2, 3))]
    for sheet in sheets(crack):
        part, edges, _ = kinks_of(sheet.points, sheet.triangles)
        if part.max() < MOST_PARTS:
            found.append(sheet.points[edges])
    return np.concatenate(found)


def cuts(corners: np.ndarray, box: np.ndarray, face: Face) -> np.ndarray:
    """Return the segments (k, 2, 3) in which triangles (n, 3, 3) cut a face of the box: its mouth there."""
    places = in_plane(corners, np.roll(corners, -1, axis=1), box, face)
    ends = np.stack([places, np.roll(places, -1, axis=1)], axis=2)
    length = np.nan_to_num(np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2), nan=-1.0)
    cut = np.flatnonzero(length.max(axis=1, initial=-1.0) >= 0)
    segments = ends[cut, length[cut].argmax(axis=1)]
    return segments[meets_box(segments, box)]


def in_plane(a: np.ndarray, b: np.ndarray, box: np.ndarray, face: Face) -> np.ndarray:
    """Return where edges from a to b (..., 3) pass the plane of a face (..., 3), NaN for others."""
    axis, upper = face
    at_a, at_b = a[..., axis] - box[upper, axis], b[..., axis] - box[upper, axis]
    share = at_a / np.where(at_a == at_b, 1.0, at_a - at_b)
    return np.where((at_a * at_b <= 0)[..., None], a + share[..., None] * (b - a), np.nan)

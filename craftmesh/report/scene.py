"""What the page's view in three dimensions is given: few triangles as short texts."""

import base64

import numpy as np

from craftmesh.report.decimated import decimated
from craftmesh.report.shown_mesh import Facets, ShownMesh

# Triangles of the body's skin and of the crack: some 180 kB of text a case and increment at most.
MOST_SKIN, MOST_LIP = 8000, 5000
LEVELS = 65535  # of coordinates within the box, and of lengths


def scene(shown: ShownMesh) -> dict:
    """Return the skin, the crack's lip and its fronts as JSON can hold them.

    Coordinates are shares of `box`, in steps of 1 / LEVELS; `length` of a corner is that share of the way
    between the two `lengths`; arrays are little-endian numbers, unsigned and of 2 bytes but for `triangles`
    and `grain` of 4, as base64.
    """
    box = np.stack([shown.points.min(axis=0), shown.points.max(axis=0)])
    lengths = np.array([shown.lengths.min(), shown.lengths.max()])
    return {
        "box": box.tolist(),
        "lengths": lengths.tolist(),
        "normal": shown.normal.tolist(),
        "towards": shown.towards.tolist(),
        "skin": _part(shown, shown.skin, box, lengths, MOST_SKIN),
        "lip": _part(shown, shown.lip, box, lengths, MOST_LIP),
        "fronts": [_text(_shares(shown.points[front], box), "<u2") for front in shown.fronts],
    }


def _part(shown: ShownMesh, facets: Facets, box: np.ndarray, lengths: np.ndarray, most: int) -> dict:
    places, triangles, rows = decimated(shown.points, facets.triangles, box, most)
    at_corner = np.zeros(len(places))
    # of the nodes that a corner stands for, those of the triangles that are left
    at_corner[triangles] = shown.lengths[facets.triangles[rows]]
    return {
        "points": _text(_shares(places, box), "<u2"),
        "triangles": _text(triangles, "<u4"),
        "grain": _text(facets.grain[rows], "<u4"),
        "length": _text(_shares(at_corner, lengths), "<u2"),
    }


def _shares(values: np.ndarray, limits: np.ndarray) -> np.ndarray:
    span = np.maximum(limits[1] - limits[0], np.finfo(float).tiny)
    return np.rint(np.clip((values - limits[0]) / span, 0, 1) * LEVELS)


def _text(values: np.ndarray, kind: str) -> str:
    return base64.b64encode(np.ascontiguousarray(values, kind).tobytes()).decode("ascii")

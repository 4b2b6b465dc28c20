"""Which crack each crack facet of a surface belongs to."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from craftmesh.surface.connectivity import pieces
from craftmesh.surface.kernels.distances import ROUNDING, nearest_facets
from craftmesh.types import Crack


def crack_numbers(points: np.ndarray, facets: np.ndarray, crack: Crack | None = None) -> np.ndarray:
    """Return the number (m,) of the crack that each crack facet (m, 3) belongs to, from 0.

    Without the given crack that is what hangs together across edges, in the order of first facets. With it
    each piece is of the given sheets that its facets lie on: the pieces into which the box or a void parts
    one sheet are one crack, sheets that have grown together are one too, and numbers follow the sheets.
    """
    piece = pieces(facets)
    if crack is None or not len(facets):
        return piece
    sheet = _nearest_sheet(points[facets].mean(axis=1), crack)
    width = int(piece.max()) + 1
    size = width + int(sheet.max()) + 1
    graph = coo_array((np.ones(len(piece), np.int8), (piece, width + sheet)), shape=(size, size))
    found = connected_components(graph, directed=False)[1]
    first = np.full(size, size)
    np.minimum.at(first, found[width + sheet], sheet)
    return np.unique(first[found[piece]], return_inverse=True)[1].ravel()


def _nearest_sheet(places: np.ndarray, crack: Crack) -> np.ndarray:
    """Return the sheet (n,) of the crack that is nearest to each place (n, 3)."""
    sheet = pieces(crack.triangles)
    if sheet.max() == 0:
        return np.zeros(len(places), np.int64)
    corners = crack.points[crack.triangles]
    centres = corners.mean(axis=1)
    reach = np.linalg.norm(corners - centres[:, None], axis=2).max(axis=1) * (1 + ROUNDING)
    some = cKDTree(centres).query(places)[1]
    triangles = crack.triangles.astype(np.int64)
    nearest: np.ndarray = nearest_facets(places, crack.points, triangles, some, centres, reach)[0]
    return sheet[nearest]

"""Where a sheet is no height over its best-fit plane."""

import numpy as np
import shapely

from craftmesh.cracks.frame import best_fit_frame
from craftmesh.errors import told
from craftmesh.surface.measure import area_vectors

STEEPEST = 0.15  # least cosine between a triangle's normal and the plane's: lengths stretch by 7 at most
LEAST_AREA = 1e-12  # share of the sheet's: the normal of a smaller triangle is rounding
COVERED = 1e-6  # share of the projected area that may be covered twice, by rounding, before it is a fold


def fold_of(points: np.ndarray, triangles: np.ndarray) -> str:
    """Return where and how much a sheet (m, 3) is no height over its best-fit plane, '' if it is one."""
    frame = best_fit_frame(points, triangles)
    vectors = area_vectors(points, triangles)
    true = np.linalg.norm(vectors, axis=1)
    seen = vectors @ frame[2]
    proper = are_proper(true)
    cosine = np.where(proper, seen / np.maximum(true, 1e-300), 1.0)
    steep = cosine < STEEPEST
    if steep.any():
        worst = int(np.argmin(cosine))
        place = told(points[triangles[worst]].mean(axis=0))
        angle, most = np.degrees(np.arccos(np.clip([cosine[worst], STEEPEST], -1, 1)))
        return (
            f"the crack surface is folded near {place}: a triangle there stands at {angle:.0f} degrees to "
            f"the plane over which the surface is most nearly a height ({int(steep.sum())} of "
            f"{len(triangles)} triangles at over {most:.0f}); expected a sheet that is a height over some "
            "plane: smooth it or cut it off there"
        )
    uv = points @ frame[:2].T
    polygons = shapely.polygons(uv[triangles[proper]])
    missing = 1 - shapely.union_all(polygons).area / seen[proper].sum()
    if missing <= COVERED:
        return ""
    place = told(_overlap(points, triangles[proper], polygons))
    return (
        f"the crack surface is folded near {place}: seen along its mean normal, {100 * missing:.2g} % of "
        "it lies over other parts; expected a sheet that is a height over some plane: cut it off there"
    )


def are_proper(areas: np.ndarray) -> np.ndarray:
    """Tell which triangles of a sheet, of these areas (m,), have a normal."""
    return areas > LEAST_AREA * areas.sum()


def _overlap(points: np.ndarray, triangles: np.ndarray, polygons: np.ndarray) -> np.ndarray:
    """Return the centre (3,) of a triangle that lies over another one, seen along the normal."""
    tree = shapely.STRtree(polygons)
    a, b = tree.query(polygons, predicate="intersects")
    apart = a < b
    a, b = a[apart], b[apart]
    over = int(np.argmax(shapely.area(shapely.intersection(polygons[a], polygons[b]))))
    return points[triangles[a[over]]].mean(axis=0)

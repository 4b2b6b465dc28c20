"""Cracks of a few edges at exact places: in boundaries, along and across lines, with corners on them."""

import numpy as np
import pytest
from plain_distances import from_edges

from craftmesh.cracks.sheets import one_crack
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.gradation.gradate import gradate
from craftmesh.insertion.insert import insert_crack
from craftmesh.remeshing.remesh import remesh
from craftmesh.sizing.sizing import Sizing, densify
from craftmesh.surface.check_surface import check_surface
from craftmesh.surface.front import front_edges
from craftmesh.surface.measure import facet_angles
from craftmesh.types import Crack, Surface, Voxels

EDGE = 16
BOX = np.array([[0.0] * 3, [EDGE] * 3])
L_MIN = 0.7
x, y, z = np.indices((EDGE,) * 3) + 0.5
LABELS = {
    "two": np.where(z < 8, 1, 2),
    "columns": 1 + (x > 8) + 2 * (y > 8),
    "bricks": np.where(z < 8, 1 + (x > 8), 3 + (x > 4)),
    "cubes": 1 + (x > 8) + 2 * (y > 8) + 4 * (z > 8),
}


def rectangle(low: tuple, high: tuple, turned: float = 0.0, tilted: float = 0.0) -> np.ndarray:
    """Corners (4, 3) of a rectangle, low to high from the middle, turned about z, then tilted about y."""
    (a, b), (c, d) = low, high
    corners = np.array([(a, b, 0), (c, b, 0), (c, d, 0), (a, d, 0)], float)
    turn, tilt = np.radians([turned, tilted])
    about_z = [(np.cos(turn), np.sin(turn), 0), (-np.sin(turn), np.cos(turn), 0), (0, 0, 1)]
    about_y = [(np.cos(tilt), 0, np.sin(tilt)), (0, 1, 0), (-np.sin(tilt), 0, np.cos(tilt))]
    return corners @ np.array(about_z) @ np.array(about_y) + 8.0


CRACKS = {
    "inner": rectangle((-4, -4), (4, 4)),
    "turned": rectangle((-4, -4), (4, 4), turned=45),
    "front_on_line": rectangle((-12, -20), (0, 20)),
    "corner": rectangle((-12, -12), (0, 0)),
    "tilted": rectangle((-12, -20), (1, 20), tilted=5),
    "steep": rectangle((-4, -4), (4, 4), tilted=90),
    "front_in_boundary": rectangle((-20, -4), (0, 4), tilted=90),
    "triangle": np.array([[4.0, 4, 8], [12, 4, 8], [8, 12, 8]]),
}


@pytest.fixture(scope="module", params=LABELS)
def surface(request) -> Surface:
    return remesh(Voxels(LABELS[request.param], (1, 1, 1), (0, 0, 0)))[0]


def sized(crack: Crack, l_min: float) -> Sizing:
    sources = np.concatenate([densify(crack.points[front], l_min / 4) for front in crack.fronts])
    return Sizing(l_min, max(1.0, l_min), 4.0, 2.0, 8.0, 1.0, sources)


@pytest.mark.sampled(5)
@pytest.mark.parametrize("name", CRACKS)
def test_a_crack_at_exact_places_comes_in_with_its_corners_and_sound_facets(surface, name):
    corners = CRACKS[name]
    fan = np.array([[0, i, i + 1] for i in range(1, len(corners) - 1)])
    crack = crack_from_triangles(corners, fan, None, BOX)
    sizing = sized(crack, L_MIN)
    inserted, _ = insert_crack(surface, crack, sizing)
    assert check_surface(inserted) == []
    inner = corners[((corners > 0) & (corners < EDGE)).all(axis=1)]
    if len(inner):
        off, _ = from_edges(inner, inserted.points, front_edges(inserted))
        assert off.max() < 0.0201 * L_MIN
    gradated, _ = gradate(inserted, sizing, crack=crack)
    assert check_surface(gradated) == []
    # 0.3 degrees where an end of a triple line stood 0.005 beside the mouth; 7.4 at least now
    assert facet_angles(gradated.points, gradated.facets).min() > 5


@pytest.mark.parametrize("l_min", [0.5, 1.0])
def test_two_cracks_that_overlap_in_a_boundary_have_the_area_of_both(surface, l_min):
    """Where their fronts cross, the first one's point slid along the second front: 0.8 % were lost."""
    corners = [rectangle((-5, -3), (1, 3)), rectangle((-1, -2), (5, 2))]
    fan = np.array([[0, 1, 2], [0, 2, 3]])
    crack = one_crack([crack_from_triangles(one, fan, None, BOX) for one in corners])
    inserted, report = insert_crack(surface, crack, sized(crack, l_min))
    assert check_surface(inserted) == []
    assert report["crack_area"] == pytest.approx(36 + 24 - 8, rel=1e-4)

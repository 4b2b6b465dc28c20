"""Long edges are split where their halves are sound; slivers between a mouth and a box edge close."""

import numpy as np
import pytest
from few_facets import sheet
from hypothesis import given, settings
from hypothesis import strategies as st
from models import voronoi
from structured_box import structured_box
from unchanged import OPEN

from craftmesh.cracks.crack_tolerances import GRADATED
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.series import prescribed_crack
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.gradation.gradate import SOUND_ANGLE, gradate
from craftmesh.gradation.passes import Gradation, filled_grid, split_all
from craftmesh.gradation.state import make_state
from craftmesh.insertion.insert import insert_crack
from craftmesh.remeshing.remesh import remesh
from craftmesh.sizing.clearance import PER_WIDTH, SHORTEST_BESIDE_LINES
from craftmesh.sizing.sizing import Sizing, SizingOptions
from craftmesh.sizing.sources import Defects, sizing_around
from craftmesh.surface.check_surface import check_surface
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.front import front_edges
from craftmesh.surface.kernels.facet_shape import angle_score, score_of_angle
from craftmesh.surface.measure import edge_lengths, facet_angles
from craftmesh.types import CRACK, Surface

LIMITS = OPEN._replace(split=1.4, floor=score_of_angle(SOUND_ANGLE))


def parted(*apexes):
    """Split the edge from x = 0 to 4 between two apexes; return the new points and scores before, after."""
    facets = [[0, 1, 2], [1, 0, 3]]
    surface = sheet(facets, points=[[0.0, 0, 0], [4.0, 0, 0], *apexes])
    state = make_state(surface, np.ones(4))
    gradation = Gradation(state, filled_grid(state.mesh), {})
    split_all(gradation, "split", LIMITS, np.array([[0, 1]]), 1.0)
    mesh = gradation.mesh
    living = mesh.facets[np.flatnonzero(mesh.alive)]
    scores = [[angle_score(mesh.points, *facet) for facet in some] for some in (facets, living)]
    return mesh.points[4 : mesh.used[0]], *scores


def test_an_edge_under_high_apexes_is_split_in_the_middle():
    new, _, _ = parted((2.5, 1.8, 0), (1.6, -2, 0))
    assert new == pytest.approx(np.array([[2, 0, 0]]), abs=1e-12)


def test_an_edge_under_a_flat_apex_whose_half_would_be_flatter_stays():
    assert not len(parted((0.7, 0.05, 0), (2, -2, 0))[0])


@pytest.mark.parametrize("height", [6.0, 20.0])
def test_strips_of_a_drawn_cylinder_get_edges_of_the_target(height):
    turns = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    ring = np.column_stack([4 * np.cos(turns), 4 * np.sin(turns)])
    points = [[*at, z] for z in (0.0, height) for at in ring] + [[0, 0, 0], [0, 0, height]]
    facets = []
    for i in range(40):
        j = (i + 1) % 40
        facets += [[i, j, 40 + i], [j, 40 + j, 40 + i], [j, i, 80], [40 + i, 40 + j, 81]]
    surface = Surface.of_facets(np.array(points), np.array(facets), (1, 0))
    gradated, _ = gradate(surface, Sizing(1.0, 1.0, 1.0, 2.0, 4.0, 1.0, np.zeros((0, 3))))
    assert not check_surface(gradated)
    lengths = edge_lengths(gradated.points, unique_edges(gradated.facets)[0])
    # 1.94 and 1.68; 2.05 where edges under 1.6 split_ratio are split into good halves alone
    assert lengths.max() < 2.0 and 0.9 < np.median(lengths) < 1.4
    # 25.6 and 27.9 degrees; 8.9 with good halves alone
    assert facet_angles(gradated.points, gradated.facets).min() > SOUND_ANGLE


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1))
def test_no_split_leaves_a_facet_worse_than_the_worst_before_and_unsound(seed):
    rng = np.random.default_rng(seed)
    apexes = np.column_stack([rng.uniform(-1, 5, 2), [1, -1] * rng.uniform(0.01, 2, 2), np.zeros(2)])
    _, before, after = parted(*apexes)
    assert min(after) >= min(LIMITS.floor, min(before)) * (1 - 1e-12)


def beside_an_edge(slope: float):
    """A box of one grain with a crack to its edge x = y = 8, which it leaves by `slope` along z."""
    surface, _ = structured_box((8, 8, 8), lambda centres: np.ones(len(centres), int))
    # the plane x - y + slope * (z - 4) = 0, from 4 inside the edge to beyond it, past both ends in z
    inner, outer = np.array([5.2, 5.2]), np.array([8.6, 8.6])
    corners = np.array([[*at, z] for at in (inner, outer) for z in (-1.0, 9.0)])
    corners[:, 0] -= slope * (corners[:, 2] - 4) / 2
    corners[:, 1] += slope * (corners[:, 2] - 4) / 2
    crack = crack_from_triangles(corners, np.array([[0, 2, 3], [0, 3, 1]]), None, surface.box)
    sizing = Sizing(1.0, 1.0, 1.0, 8.0, 16.0, 1.0, crack.points[np.concatenate(crack.fronts)])
    return insert_crack(surface, crack, sizing)[0], crack, sizing


def test_a_mouth_that_hardly_leaves_an_edge_of_the_box_goes_onto_it():
    inserted, crack, sizing = beside_an_edge(0.02)
    thin = sliver_widths(inserted)
    assert len(thin) > 3 and thin.max() < 0.081
    gradated, _ = gradate(inserted, sizing, crack=crack)
    assert not check_surface(gradated)
    assert sliver_widths(gradated).min(initial=1.0) > 0.04
    points = gradated.points[np.unique(gradated.facets[gradated.kind == CRACK])]
    off = (points[:, 0] - points[:, 1] + 0.02 * (points[:, 2] - 4)) / np.sqrt(2)
    assert np.abs(off).max() <= GRADATED


def test_a_front_beside_a_face_is_split_onto_its_arc_that_is_nearer_to_the_face_than_its_chords():
    surface, _ = remesh(voronoi(3, 10, (20, 20, 20)))
    options = CrackOptions(centre=(10, 8 + 0.0175, 10), normal=(0, 0, 1), radius=8.0)
    crack = prescribed_crack(surface.box, options)
    sizes = SizingOptions(l_min=0.7, l0=1.0, l_max=3.0, r0=2.0, r1=8.0)
    sizing = sizing_around(surface, Defects(crack), sizes)
    inserted, _ = insert_crack(surface, crack, sizing)
    gradated, _ = gradate(inserted, sizing, crack=crack)
    assert not check_surface(gradated)
    ends = gradated.points[front_edges(gradated)]
    length, gap = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), ends[..., 1].max(axis=1)
    near = gap < 0.05
    assert near.sum() >= 2
    # lengths grow by half the distance between their places, and two of nine edges here were two beside
    # needles of the crack: 2.81 and 2.05 times; chords of 0.7 stay without clearance
    assert (length[near] <= 3 * np.maximum(PER_WIDTH * gap[near], SHORTEST_BESIDE_LINES * 0.7)).all()


def sliver_widths(surface) -> np.ndarray:
    """Return how far (k,) the crack's points on the faces x = 8 or y = 8 are from the edge of both."""
    points = surface.points[np.unique(surface.facets[surface.kind == CRACK])]
    on = points[(points[:, 0] == 8) | (points[:, 1] == 8)]
    widths = 8 - on[:, :2].min(axis=1)
    return widths[widths > 0]

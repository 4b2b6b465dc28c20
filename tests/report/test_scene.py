"""The view's data: few triangles, where the mesh has its own."""

import base64

import numpy as np
import pytest
from shown_models import AREA, SHAPE, cracked_box

from craftmesh.report.shown_mesh import LEVELS, decimated, fronts_of, scene, shown_mesh
from craftmesh.surface.measure import area_vectors

BOX = np.array([[0.0, 0.0, 0.0], SHAPE])


def areas(points, triangles):
    return np.linalg.norm(area_vectors(points, triangles), axis=1)


@pytest.fixture(scope="module")
def shown():
    return shown_mesh(cracked_box())


def test_few_triangles_stay_as_they_are(shown):
    points, triangles, rows = decimated(shown.points, shown.skin.triangles, BOX, 10_000)
    assert (points[triangles] == shown.points[shown.skin.triangles]).all()
    assert rows.tolist() == list(range(len(triangles)))


@pytest.mark.parametrize("most", [200, 100, 48])
def test_a_coarser_box_is_still_the_box(shown, most):
    points, triangles, rows = decimated(shown.points, shown.skin.triangles, BOX, most)
    assert 12 <= len(triangles) <= most and len(rows) == len(triangles)
    assert areas(points, triangles).sum() == pytest.approx(areas(shown.points, shown.skin.triangles).sum())
    corners = np.stack(np.meshgrid(*BOX.T, indexing="ij"), axis=-1).reshape(-1, 3)
    assert all((points == corner).all(axis=1).any() for corner in corners)
    assert (areas(points, triangles) > 0).all()


def test_where_the_box_takes_more_triangles_than_asked_for_they_are_as_few_as_can_be(shown):
    _, fewest, _ = decimated(shown.points, shown.skin.triangles, BOX, 1)
    _, few, _ = decimated(shown.points, shown.skin.triangles, BOX, 48)
    assert len(fewest) == len(few) == 48


def test_places_survive_to_a_step_of_the_box(shown):
    made = scene(shown)
    places = np.frombuffer(base64.b64decode(made["lip"]["points"]), "<u2").reshape(-1, 3) / LEVELS
    triangles = np.frombuffer(base64.b64decode(made["lip"]["triangles"]), "<u4").reshape(-1, 3)
    points = BOX[0] + places * (BOX[1] - BOX[0])
    # a corner is off by half a step at most
    assert areas(points, triangles.astype(int)).sum() == pytest.approx(AREA, rel=12 / LEVELS)
    front = np.frombuffer(base64.b64decode(made["fronts"][0]), "<u2").reshape(-1, 3) / LEVELS
    assert np.allclose(BOX[0] + front * BOX[1], shown.points[shown.fronts[0]], atol=6 / LEVELS)
    assert np.allclose(fronts_of(made)[0], shown.points[shown.fronts[0]], atol=6 / LEVELS)
    opened = np.frombuffer(base64.b64decode(made["opened"]["grain"]), "<u4")
    assert np.count_nonzero(opened == 0) == len(
        shown.lip.triangles
    )  # the crack's face and the grains round it
    grain = np.frombuffer(base64.b64decode(made["skin"]["grain"]), "<u4")
    assert grain.tolist() == shown.skin.grain.tolist()

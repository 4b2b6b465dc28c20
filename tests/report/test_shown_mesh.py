"""What is shown of a mesh is its own: skin, lip and the opened body have their areas."""

import numpy as np
import pytest
from shown_models import AREA, SHAPE, cracked_box
from structured_box import structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.report.mesh_pictures import mesh_pictures
from craftmesh.report.shown_mesh import shown_mesh
from craftmesh.surface.measure import area_vectors


def area(shown, facets):
    return np.linalg.norm(area_vectors(shown.points, facets.triangles), axis=1).sum()


def test_skin_and_lip_have_the_areas_of_box_and_crack():
    shown = shown_mesh(cracked_box())
    x, y, z = SHAPE
    assert area(shown, shown.skin) == pytest.approx(2 * (x * y + y * z + z * x))
    assert area(shown, shown.lip) == pytest.approx(AREA)
    assert not shown.skin.is_lip.any() and shown.lip.is_lip.all()
    assert len(shown.fronts) == 1 and np.allclose(shown.points[shown.fronts[0]][:, [0, 2]], [3, 2])


def test_the_body_is_cut_open_at_the_crack():
    shown = shown_mesh(cracked_box())
    x, y, z = SHAPE
    assert shown.points[shown.opened.triangles][..., 2].max() == 2  # elements do not cross the plane
    assert area(shown, shown.opened) == pytest.approx(2 * (x * y + (y + x) * z / 2))
    assert area(shown, shown.opened._replace(triangles=shown.opened.triangles[shown.opened.is_lip])) == (
        pytest.approx(AREA)
    )
    total = area_vectors(shown.points, shown.opened.triangles).sum(axis=0)
    assert np.allclose(total, 0)  # it is closed
    assert shown.towards @ shown.normal > 0


def test_new_elements_are_coloured_and_those_of_the_mesh_before_are_grey():
    shown = shown_mesh(cracked_box())
    assert "renewed" not in mesh_pictures(shown)
    figures = [mesh_pictures(shown, new=rows)["renewed"] for rows in (shown.opened.element[::2], [])]
    drawn = [figure.axes[0].images[0].get_array() for figure in figures]
    grey = [(np.ptp(picture[..., :3], axis=2) < 0.01).mean() for picture in drawn]
    assert grey[0] < grey[1] == 1.0


def test_lengths_are_the_means_of_the_edges_at_a_node():
    shown = shown_mesh(cracked_box())
    # of a corner of cubes cut along their diagonal: three edges, three diagonals of faces, one of the cube
    corner = np.flatnonzero((shown.points == 0).all(axis=1))
    assert shown.lengths[corner] == pytest.approx((3 + 3 * np.sqrt(2) + np.sqrt(3)) / 7)


def test_a_mesh_without_a_crack_is_cut_in_the_middle():
    shown = shown_mesh(assemble(*structured_box((2, 2, 4), lambda centres: np.ones(len(centres), int)))[0])
    assert len(shown.lip.triangles) == 0 and shown.fronts == []
    assert shown.points[shown.opened.triangles][..., 2].max() == 2

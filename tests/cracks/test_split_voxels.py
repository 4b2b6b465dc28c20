"""Labels split on either side of a crack, and what a sheet is to places near it."""

import numpy as np
import pytest
from models import voronoi

from craftmesh.cracks.near_sheet import NearSheet, feet_in_triangles
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.series import prescribed_crack
from craftmesh.cracks.split_voxels import BAND, split_along
from craftmesh.cracks.triangulated import crack_from_triangles

VOXELS = voronoi(3, 6, (14, 14, 14))
CENTRE, NORMAL, RADIUS = np.array([7.0, 6.8, 7.1]), np.array([0.2, 0.3, 1.0]), 4.0
PENNY = prescribed_crack(
    CrackOptions(centre=tuple(CENTRE), normal=tuple(NORMAL), radius=RADIUS), 0, VOXELS.box
)


def in_plane(places):
    """Height over the penny's plane, and distance from its axis."""
    n = NORMAL / np.linalg.norm(NORMAL)
    height = (places - CENTRE) @ n
    return height, np.linalg.norm(places - CENTRE - height[:, None] * n, axis=1)


def test_voxels_near_the_crack_are_told_by_sides_and_others_are_not():
    split = split_along(VOXELS, PENNY)
    assert (split.label[split.labels] == VOXELS.labels).all()
    index = np.stack(np.indices((14, 14, 14)), axis=-1).reshape(-1, 3)
    places = np.where(index == 0, 0.0, np.where(index == 13, 14.0, index + 0.5))  # at faces what is there
    side = split.side[split.labels.ravel(), 0]
    height, out = in_plane(places)
    distance = np.hypot(height, np.maximum(out - RADIUS, 0))
    # the penny is a polygon, so that the band's end is not known to a hair
    near, far = distance < BAND - 0.01, distance > BAND + 0.01
    turn = np.sign(
        NORMAL @ np.cross(*(PENNY.points[PENNY.triangles[0, [1, 2]]] - PENNY.points[PENNY.triangles[0, 0]]))
    )
    assert near.sum() > 200 and (side[near] == turn * np.sign(height[near])).all()
    assert (side[far] == 0).all()


def test_what_a_penny_is_to_places():
    look = NearSheet(PENNY, VOXELS.box)
    places = np.random.default_rng(1).random((400, 3)) * 14
    near = look.look(places)
    height, out = in_plane(places)
    assert np.abs(near.psi) == pytest.approx(np.abs(height), abs=1e-9)
    # a polygon's sagitta: 4 (1 - cos(pi / n)) of its n edges
    assert near.phi == pytest.approx(RADIUS - out, abs=1e-3)
    assert np.linalg.norm(near.normal, axis=1) == pytest.approx(1)


def test_a_sharp_ridge_has_one_side_beyond_it():
    """At 40 degrees a place beyond the ridge is behind one triangle's plane, but ahead of the sheet."""
    lean = np.tan(np.radians(20.0))
    points = np.array([[5, 4, 7], [5, 10, 7], [5 - 3 * lean, 7, 4], [5 + 3 * lean, 7, 4]], float)
    triangles = np.array([[0, 1, 2], [1, 0, 3]])
    sheet = crack_from_triangles(points, triangles, None, VOXELS.box, heights=False)
    look = NearSheet(sheet, VOXELS.box)
    above = look.look(np.array([[5.9, 7, 7.2], [4.1, 7, 7.2], [5, 7, 7.5]]))
    below = look.look(np.array([[5.0, 7, 5.5]]))
    assert len(np.unique(np.sign(above.psi))) == 1 and np.sign(below.psi[0]) == -np.sign(above.psi[0])


def test_feet_in_triangles_are_nearest():
    generator = np.random.default_rng(5)
    corners, places = generator.random((200, 3, 3)), 2 * generator.random((200, 3)) - 0.5
    foot, weight = feet_in_triangles(places, corners)
    assert (weight >= 0).all() and weight.sum(axis=1) == pytest.approx(1)
    s, t = (x.ravel() for x in np.meshgrid(np.linspace(0, 1, 60), np.linspace(0, 1, 60)))
    s, t = s[s + t <= 1], t[s + t <= 1]
    tried = np.einsum("kw,nwd->nkd", np.column_stack([1 - s - t, s, t]), corners)
    best = np.linalg.norm(tried - places[:, None], axis=2).min(axis=1)
    found = np.linalg.norm(foot - places, axis=1)
    assert (found <= best + 1e-12).all() and (found > best - 0.03).all()

"""A first crack begins at the root of a notch, whichever face it opens in, else on the body."""

from itertools import permutations

import numpy as np
import pytest

from craftmesh.voxels.mouth import find_mouth

SHAPE = (32, 30, 28)
X, Y, Z = np.indices(SHAPE)
BODIES = {
    "a ball": (X - 15.5) ** 2 + (Y - 14.5) ** 2 + (Z - 13.5) ** 2 < 14**2,
    "a cylinder": (X - 15.5) ** 2 + (Y - 14.5) ** 2 < 15**2,
    "a tube": np.abs((X - 15.5) ** 2 + (Y - 14.5) ** 2 - 150) < 75,
    "bodies in the corners": (abs(X - 16) > 8) & (abs(Y - 15) > 7) & (abs(Z - 14) > 6),
    "half gone": Y + 0.7 * X > 25,
    "a frame": (abs(X - 15.5) > 12) | (abs(Z - 13.5) > 10),
    "one voxel": (X == 3) & (Y == 4) & (Z == 5),
}


def mouth_of(body, spacing=(1.0, 1.0, 1.0)):
    radius = 0.25 * float((body.shape * np.array(spacing)).min())
    return find_mouth(body, np.array(spacing), radius, radius / 4), radius


def is_on_material(body, mouth) -> bool:
    """Whether the voxel ahead of the mouth is of the body, and the one before it is not."""
    axis = "xyz".index(mouth.face[0])
    inward = -1 if mouth.face.endswith("max") else 1
    half = np.eye(3)[axis] * inward * 0.5
    padded = np.pad(body, 1)
    ahead, before = (tuple(np.floor(mouth.place + step + 1).astype(int)) for step in (half, -half))
    return bool(padded[ahead]) and not padded[before]


@pytest.mark.parametrize("spacing", [(1.0, 1.0, 1.0), (0.5, 1.0, 2.0)])
@pytest.mark.parametrize("is_upper", [False, True])
@pytest.mark.parametrize("inward, normal", list(permutations(range(3), 2)))
def test_a_slot_is_found_on_each_face_and_opened(inward, normal, is_upper, spacing):
    depth, wide = 8, slice(9, 12)
    body = np.ones(SHAPE, bool)
    lines = np.moveaxis(body, (inward, normal), (0, 1))
    lines[(-depth if is_upper else 0) : (None if is_upper else depth), wide] = False
    mouth, radius = mouth_of(body, spacing)
    assert mouth.face == f"{'xyz'[inward]} = {'max' if is_upper else 'min'}" and mouth.normal == normal
    assert mouth.notch == depth * spacing[inward] and 0 < mouth.radius <= radius
    assert mouth.place[normal] == 10.5  # the middle of the slot
    assert mouth.place[inward] == (SHAPE[inward] - depth if is_upper else depth)
    assert is_on_material(body, mouth)


@pytest.mark.parametrize("name", BODIES)
def test_any_body_has_a_mouth_on_material(name):
    mouth, radius = mouth_of(BODIES[name])
    assert is_on_material(BODIES[name], mouth) and 0 < mouth.radius <= radius


def test_a_whole_box_has_it_in_the_middle_of_its_first_face():
    mouth, radius = mouth_of(np.ones(SHAPE, bool))
    assert mouth.place.tolist() == [16, 0, 14] and mouth.normal == 2 and mouth.notch == 0
    assert mouth.radius == radius


def test_a_shallow_pit_is_roughness_and_what_is_left_ahead_bounds_the_radius():
    body = np.ones(SHAPE, bool)
    body[20, 0, 9] = False
    assert mouth_of(body)[0].notch == 0
    body[:, :25, 13:15] = False
    assert mouth_of(body)[0].radius == 2.5  # half of the five voxels ahead

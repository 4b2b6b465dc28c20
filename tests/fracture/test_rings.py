"""J on rings, and the opening of lips, from exact fields at the nodes."""

import numpy as np
import pytest
from near_fields import POISSON, YOUNG, polar, williams
from structured_box import plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.fracture.rings import NodalField, front_rings
from craftmesh.mesh.second_order import raise_order

AXES = np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]])  # binormal, normal and tangent of the front along y


def unit_k(ahead=5):
    """A crack behind x = 0 in z = 0 with edges of one, under K_I of 1 in plane strain."""
    crack = plane_crack(2, 5, lambda c: c[:, 0] < 5)
    mesh = raise_order(
        assemble(
            *structured_box((5 + ahead, 3, 10), lambda c: np.ones(len(c), int), crack, origin=(-5, 0, -5))
        )[0]
    )
    r, theta = polar(mesh.points)
    on = [np.isin(np.arange(len(r)), mesh.node_sets[f"CRACK_LIP_{lip}"]) for lip in "AB"]
    theta = np.where(on[0] & ~on[1], np.pi, np.where(on[1] & ~on[0], -np.pi, theta))
    half, scale = theta / 2, np.cos(theta / 2) / np.sqrt(2 * np.pi * np.maximum(r, 1e-9))
    s11 = scale * (1 - np.sin(half) * np.sin(3 * half))
    s22 = scale * (1 + np.sin(half) * np.sin(3 * half))
    s12 = scale * np.sin(half) * np.cos(3 * half)
    s33 = POISSON * (s11 + s22)
    stress = np.stack([s11, s33, s22, 0 * r, s12, 0 * r], axis=1)  # in x, y, z
    squares = s11**2 + s22**2 + s33**2 + 2 * s12**2
    work = ((1 + POISSON) * squares - POISSON * (s11 + s22 + s33) ** 2) / (2 * YOUNG)
    return mesh, NodalField(williams(r, theta, 1) @ AXES, stress, work)


def test_each_ring_gives_j_of_the_field_and_the_lips_their_opening():
    mesh, field = unit_k()
    (found,) = front_rings(mesh, field)
    exact = (1 - POISSON**2) / YOUNG
    # the first has elements at the front, where stresses have no bound
    assert found.J[1:] == pytest.approx([exact, exact], rel=1e-3)
    opening = 8 * exact / np.sqrt(2 * np.pi)  # at r = 1
    assert found.opening == pytest.approx(opening, rel=1e-9) == found.largest_opening


def test_work_moves_j_alike_on_all_rings_and_rings_without_room_have_none():
    mesh, field = unit_k()
    (more,) = front_rings(mesh, field._replace(work=2 * field.work))
    exact = (1 - POISSON**2) / YOUNG
    # of a Williams field W gives (1 - 2 nu) / (4 (1 - nu)) of J
    assert more.J[1:] == pytest.approx([exact * (1 + 1 / 7)] * 2, rel=1e-3)
    (near,) = front_rings(*unit_k(ahead=3))
    assert np.isnan(near.J).tolist() == [False, False, True]

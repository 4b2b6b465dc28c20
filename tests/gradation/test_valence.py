"""Swaps that bring vertices nearer to six facets: fewer too many or too few, sound facets, none moved."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from structured_box import structured_box
from unchanged import OPEN

from craftmesh.gradation.passes import Gradation, even_valences, filled_grid, swap_all
from craftmesh.gradation.state import Mesh, make_state
from craftmesh.surface.kernels.facet_shape import score_of_angle
from craftmesh.surface.measure import facet_angles

# Degrees.
FLOOR = 15.0
LIMITS = OPEN._replace(floor=score_of_angle(FLOOR))


def uneven(seed: int) -> Gradation:
    """Two grains whose vertices inside patches are off their places, with the diagonals that suit these."""
    surface, _ = structured_box((5, 5, 5), lambda centres: 1 + (centres[:, 0] > 3))
    state = make_state(surface, np.ones(len(surface.points)))
    mesh, rng = state.mesh, np.random.default_rng(seed)
    for v in np.flatnonzero((mesh.first >= 0) & (mesh.rank == 0)):
        lies_in = (mesh.points[v] == 0) | (mesh.points[v] == 5)
        if not lies_in.any():
            lies_in[0] = True  # the grain boundary
        mesh.points[v] += np.where(lies_in, 0.0, rng.uniform(-0.35, 0.35, 3))
    gradation = Gradation(state, filled_grid(mesh), {})
    swap_all(gradation, OPEN)
    return gradation


def living_facets(mesh: Mesh) -> np.ndarray:
    return mesh.facets[: mesh.used[1]][mesh.alive[: mesh.used[1]]]


def too_many(mesh: Mesh) -> float:
    """Plain reference: the sum of the squares of facets too many or too few, over patches and vertices."""
    rows = np.flatnonzero(mesh.alive[: mesh.used[1]])
    angles = np.radians(facet_angles(mesh.points, mesh.facets[rows]))
    count: dict[tuple[int, int], list[float]] = {}
    for row, angle in zip(rows, angles):
        for v, own in zip(mesh.facets[row], angle):
            count.setdefault((int(v), int(mesh.patch[row])), []).append(own)
    wanted = {key: 6.0 if mesh.rank[key[0]] == 0 else sum(own) / (np.pi / 3) for key, own in count.items()}
    return sum((len(own) - wanted[key]) ** 2 for key, own in count.items())


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6))
def test_valences_come_nearer_to_six_and_no_vertex_moves(seed):
    gradation = uneven(seed)
    mesh = gradation.mesh
    before, points = too_many(mesh), mesh.points.copy()
    worst, count = facet_angles(points, living_facets(mesh)).min(), len(living_facets(mesh))
    done = even_valences(gradation, LIMITS)
    facets = living_facets(gradation.mesh)
    assert too_many(gradation.mesh) <= before - 0.5 * done + 1e-9
    assert np.array_equal(gradation.mesh.points[: len(points)], points) and len(facets) == count
    assert facet_angles(points, facets).min() >= min(worst, FLOOR) - 1e-6


def test_valences_of_uneven_patches_are_evened_and_those_of_even_ones_left():
    assert sum(even_valences(uneven(seed), LIMITS) for seed in range(5)) > 20
    surface, _ = structured_box((5, 5, 5), lambda centres: 1 + (centres[:, 0] > 3))
    state = make_state(surface, np.ones(len(surface.points)))
    assert even_valences(Gradation(state, filled_grid(state.mesh), {}), LIMITS) == 0

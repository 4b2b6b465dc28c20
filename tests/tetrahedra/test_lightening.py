"""What tets at fault weigh, and the changes that make them weigh less, keep the mesh and end."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from test_optimise_tets import assert_is_mesh, boundary, random_ball, random_tet, try_all

from craftmesh.mesh.shape_measures import is_flat, is_poor, shape_measures
from craftmesh.mesh.tet_connectivity import tet_volumes
from craftmesh.tetrahedra.kernels.tet_cavity import TETS, new_scratch
from craftmesh.tetrahedra.kernels.tet_faults import (
    FALL,
    NO_TET,
    OF_FLAT,
    OF_POOR,
    OF_STRETCHED,
    RAMP,
    SOUND_FROM,
    fault_weight,
    faults_of,
)
from craftmesh.tetrahedra.kernels.tet_lightening import (
    REMOVAL_FALL,
    lighten,
    lighten_by_contraction,
    lighten_by_face,
    lighten_by_insertion,
    lighten_by_move,
)
from craftmesh.tetrahedra.kernels.tet_passes import lighten_pass
from craftmesh.tetrahedra.kernels.tet_quality import WHOLE, Aim, all_qualities, quality_of
from craftmesh.tetrahedra.kernels.tet_sum_swaps import SumAim, remove_edge_for_sum
from craftmesh.tetrahedra.opening_model import is_stretched
from craftmesh.tetrahedra.optimise_tets import _result, new_state


@settings(max_examples=300, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.02, 1.0))
def test_weights_tell_flat_poor_stretched_and_sound_tets(seed, flatness):
    corners = random_tet(seed, flatness)
    quality = quality_of(corners, 0, 1, 2, 3, WHOLE)
    assume(quality > 1e-4)
    weight = fault_weight(quality)
    measures = shape_measures(corners, np.array([[0, 1, 2, 3]]))
    assert weight >= OF_FLAT or not is_flat(measures)[0]
    assert weight >= OF_POOR or not is_poor(measures)[0]
    assert weight >= OF_STRETCHED or not is_stretched(measures)[0]
    assert (weight == 0) == (quality >= SOUND_FROM + RAMP)


def test_a_tet_weighs_the_less_the_better_it_is():
    weights = np.array([fault_weight(quality) for quality in np.linspace(-0.1, 0.6, 2000)])
    assert (np.diff(weights) <= 0).all()
    assert weights[0] == NO_TET and weights[-1] == 0


def contract_corner(state, t, k, work):
    v, w = state.tets[t, k % 4], state.tets[t, (k + 1) % 4]
    return not state.frozen[v] and lighten_by_contraction(state, v, w, work)


def move_corner(state, t, k, work):
    v = state.tets[t, k % 4]
    return not state.frozen[v] and lighten_by_move(state, v, work)


OPERATIONS = {
    "edge removal": lambda state, t, k, work: remove_edge_for_sum(
        state, t, k, SumAim(WHOLE, 0.0, 0.0, REMOVAL_FALL), work
    ),
    "face removal": lambda state, t, k, work: k < 4 and lighten_by_face(state, t, k, work),
    "contraction": contract_corner,
    "insertion": lighten_by_insertion,
    "move": move_corner,
    "any": lambda state, t, k, work: k == 0 and state.quality[t] < SOUND_FROM and lighten(state, t, work),
}


@pytest.mark.parametrize("name", OPERATIONS)
def test_each_change_makes_the_mesh_lighter_and_keeps_it_a_mesh(name):
    def checked(state, t, k, work):
        before = weight_of(state)
        done = OPERATIONS[name](state, t, k, work)
        after = weight_of(state)
        # of a sum over some hundred tets the rounding
        assert after <= before - min(FALL, REMOVAL_FALL) + 1e-6 if done else after == before
        return done

    state, done, volume, frozen = try_all(checked, seed=5, measure=WHOLE)
    assert done > 3
    assert_is_mesh(state, frozen, volume, WHOLE)


def weight_of(state):
    living = np.flatnonzero(state.tets[: state.counts[TETS], 0] >= 0)
    return faults_of(state, living, len(living))


@settings(max_examples=2, deadline=None)
@given(st.integers(0, 10**6))
def test_passes_leave_fewer_tets_at_fault_and_end(seed):
    points, tets, frozen = random_ball(seed, count=60)
    assume(tet_volumes(points, tets).min() > 1e-8)
    state = new_state(points, tets, frozen, np.zeros((0, 3)), np.full(len(points), 0.35))
    all_qualities(state.points, state.tets, len(tets), state.quality, WHOLE)
    before, work = weight_of(state), new_scratch()
    # each change lowers the weight by a hundredth at least, so that there is an end
    while lighten_pass(state, Aim(WHOLE, SOUND_FROM), np.arange(state.counts[TETS]), work):
        assert weight_of(state) < before
        before = weight_of(state)
    new, better = _result(state, frozen)
    assert boundary(better) == boundary(tets)
    assert new[:frozen].tobytes() == points[:frozen].tobytes()
    was, now = (shape_measures(*mesh) for mesh in ((points, tets), (new, better)))
    assert is_flat(now).sum() < is_flat(was).sum()
    assert (is_poor(now) | is_stretched(now)).sum() < (is_poor(was) | is_stretched(was)).sum()

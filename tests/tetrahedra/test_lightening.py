"""What tets at fault weigh, and the changes that make them weigh less, keep the mesh and end."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from test_optimise_tets import assert_is_mesh, boundary, random_ball, random_tet, try_all

from craftmesh.mesh.shape_measures import is_flat, is_poor, shape_measures
from craftmesh.mesh.tet_connectivity import tet_volumes
from craftmesh.tetrahedra.kernels.tet_cavity import TETS, new_scratch
from craftmesh.tetrahedra.kernels.tet_objective import (
    FALL,
    FAULTS,
    NO_TET,
    OF_FLAT,
    OF_POOR,
    OF_STRETCHED,
    RAMP,
    SOUND_FROM,
    Aim,
    fault_weight,
)
from craftmesh.tetrahedra.kernels.tet_operations import (
    contract,
    insert_on_edge,
    remove_edge,
    remove_face,
)
from craftmesh.tetrahedra.kernels.tet_passes import improve, improve_pass
from craftmesh.tetrahedra.kernels.tet_quality import COMBINED_QUALITY, all_qualities, quality_of
from craftmesh.tetrahedra.kernels.tet_smoothing import move_point, weight_of
from craftmesh.tetrahedra.surface_moves import is_stretched
from craftmesh.tetrahedra.tet_state import mesh_of, new_state


@settings(max_examples=300)
@given(st.integers(0, 10**6), st.floats(0.02, 1.0))
def test_weights_tell_flat_poor_stretched_and_sound_tets(seed, flatness):
    corners = random_tet(seed, flatness)
    quality = quality_of(corners, 0, 1, 2, 3, COMBINED_QUALITY)
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


def test_a_tet_without_volume_weighs_more_than_any_other():
    """Else a move might invert a sliver, as it did in one of 20 random cracks."""
    assert fault_weight(0.0) == fault_weight(-0.1) > 1.5 * fault_weight(1e-30)


LIGHTER = Aim(FAULTS, COMBINED_QUALITY, SOUND_FROM, FALL, 0.0)


def at_corner(change):
    """The change of a point, at corner k of tet t where that is inside."""
    return lambda state, t, k, work: (
        not state.frozen[state.tets[t, k % 4]] and change(state, state.tets[t, k % 4], work)
    )


OPERATIONS = {
    "edge removal": lambda state, t, k, work: remove_edge(state, t, k, LIGHTER, work),
    "face removal": lambda state, t, k, work: k < 4 and remove_face(state, t, k, LIGHTER, work),
    "contraction": at_corner(lambda state, v, work: contract(state, v, LIGHTER, work)),
    "insertion": lambda state, t, k, work: insert_on_edge(state, t, k, LIGHTER, work) >= 0,
    "move": at_corner(lambda state, v, work: move_point(state, v, LIGHTER, work)),
    "any": lambda state, t, k, work: (
        k == 0 and state.quality[t] < SOUND_FROM and improve(state, t, LIGHTER, True, work)
    ),
}


@pytest.mark.parametrize("name", OPERATIONS)
def test_each_change_makes_the_mesh_lighter_and_keeps_it_a_mesh(name):
    def checked(state, t, k, work):
        before = whole_weight(state)
        done = OPERATIONS[name](state, t, k, work)
        after = whole_weight(state)
        # of a sum over some hundred tets the rounding
        assert after <= before - FALL + 1e-6 if done else after == before
        return done

    state, done, volume, frozen = try_all(checked, seed=5, measure=COMBINED_QUALITY)
    assert done > 3
    assert_is_mesh(state, frozen, volume, COMBINED_QUALITY)


def whole_weight(state):
    living = np.flatnonzero(state.tets[: state.counts[TETS], 0] >= 0)
    return weight_of(state, living, len(living))


@settings(max_examples=2)
@given(st.integers(0, 10**6))
def test_passes_leave_fewer_tets_at_fault_and_end(seed):
    points, tets, frozen = random_ball(seed, count=40)
    assume(tet_volumes(points, tets).min() > 1e-8)
    state = new_state(points, tets, frozen, np.zeros((0, 3)), np.full(len(points), 0.35))
    all_qualities(state.points, state.tets, len(tets), state.quality, COMBINED_QUALITY)
    before, work, looked_at = whole_weight(state), new_scratch(), np.zeros(len(state.points), bool)
    # each change lowers the weight by FALL at least, so that there is an end
    while improve_pass(state, LIGHTER, np.arange(state.counts[TETS]), True, looked_at, work):
        assert whole_weight(state) < before
        before = whole_weight(state)
    new, better = mesh_of(state, frozen)
    assert boundary(better) == boundary(tets)
    assert new[:frozen].tobytes() == points[:frozen].tobytes()
    was, now = (shape_measures(*mesh) for mesh in ((points, tets), (new, better)))
    assert is_flat(now).sum() < is_flat(was).sum()
    assert (is_poor(now) | is_stretched(now)).sum() < (is_poor(was) | is_stretched(was)).sum()

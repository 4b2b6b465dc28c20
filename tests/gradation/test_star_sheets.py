"""Stars in one sheet: what the guard against intersections leaves out is what no facet meets."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from structured_box import structured_box
from unchanged import OPEN

from craftmesh.gradation.kernels.guards import refusal
from craftmesh.gradation.kernels.result_codes import INTERSECTION
from craftmesh.gradation.kernels.sheets import EMPTY, MIXED, Sheet, goes_on, join, set_rows, sheet_of
from craftmesh.gradation.kernels.star import star_at
from craftmesh.gradation.passes import filled_grid
from craftmesh.gradation.state import make_state
from craftmesh.kernel_structs import by_reference
from craftmesh.surface.kernels.triangles import triangles_intersect
from craftmesh.types import Surface

seeds = st.integers(0, 2**32 - 1)


def thin_grains(rng: np.random.Generator) -> Surface:
    """Return a box of three grains with uneven points, the middle one a layer of one cell with a step."""

    def label(centres):
        low = 1 + (centres[:, 1] > 3)
        return 1 + (centres[:, 0] > low) + (centres[:, 0] > low + 1)

    surface, _ = structured_box((5, 6, 4), label)
    inside = ((surface.points > 0) & (surface.points < surface.points.max(axis=0))).all(axis=1)
    # Tetrahedra of unit cells are turned inside out by moves of 0.14 or more.
    points = surface.points + inside[:, None] * rng.uniform(-0.12, 0.12, surface.points.shape)
    return Surface(points, surface.facets, surface.sides, surface.kind)


def meets(points: np.ndarray, new: np.ndarray, others: np.ndarray) -> bool:
    """Tell whether new facets meet each other or others, pair by pair."""
    pairs = [(f, g) for i, f in enumerate(new) for g in [*new[:i], *others]]
    return any(triangles_intersect(points, *f, *g) for f, g in pairs)


@settings(max_examples=25)
@given(seeds)
def test_a_move_is_refused_where_its_facets_meet_any_others_pair_by_pair(seed):
    rng = np.random.default_rng(seed)
    state = make_state(surface := thin_grains(rng), np.ones(len(surface.points)))
    mesh, grid = by_reference(*state), by_reference(filled_grid(state.mesh))
    facets, sheets = state.mesh.facets, 0
    for v in rng.choice(np.flatnonzero(state.mesh.rank[:-1] == 0), 12, replace=False):
        star = star_at(mesh, v)
        state.mesh.points[star.tip] += rng.uniform(-1, 1, 3) * rng.choice([0.2, 1.5])
        at_v = (facets == v).any(axis=1)
        new = np.where(facets[at_v] == v, star.tip, facets[at_v])
        wanted = meets(state.mesh.points, new, facets[~at_v])
        assert (refusal(mesh, grid, OPEN, star, 0.0, 0.0) == INTERSECTION) == wanted
        set_rows(mesh, star)
        sheets += sheet_of(mesh, star).patch >= 0
    assert sheets > 0


@settings(max_examples=100)
@given(seeds)
def test_cells_go_on_with_a_sheet_where_their_facets_are_of_its_patch_and_face_its_way(seed):
    rng = np.random.default_rng(seed)
    normal = rng.normal(size=3)
    normal /= np.linalg.norm(normal)
    vectors = 2.0 ** rng.integers(-20, 20) * (normal + rng.choice([0.1, 1.0]) * rng.normal(size=(4, 3)))
    patches = rng.choice([3, 4], 4, p=[0.9, 0.1])
    common = EMPTY
    for patch, vector in zip(patches, vectors):
        common = join(common, patch, *vector)
    if goes_on(common, Sheet(3, *normal)):
        assert (patches == 3).all() and (vectors @ normal > 0).all()
    assert not goes_on(common, Sheet(-1, *normal))
    # A way is within 28 degrees of its first facet, and a sheet may be 38 off it.
    assert goes_on(join(join(EMPTY, 3, *normal), 3, *normal), Sheet(3, *normal))
    assert not goes_on(MIXED, Sheet(3, *normal))

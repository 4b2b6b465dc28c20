"""Patches of the crack end at its sharp folds, so that normals are not averaged across them."""

import numpy as np
import pytest
from few_facets import sheet

from craftmesh.gradation.folds import FOLD, PER_WIDTH, folded_patches, short_beside_folds
from craftmesh.gradation.state import make_state, surface_of
from craftmesh.sizing.sizing import FREE_GROWTH, Sizing
from craftmesh.surface.measure import unit_normals
from craftmesh.types import CRACK, INTERFACE, Surface

ROWS, COLUMNS = 13, 7
SEAM = 3


def folded(turn: float, kind=CRACK, turned=False, ends=False) -> Surface:
    """A strip of one grain folded by `turn` degrees along column SEAM; turned: beyond it facets face back.

    ends: the fold gets less from row to row, to none at the last.
    """
    x, y = np.meshgrid(np.arange(ROWS, dtype=float), np.arange(COLUMNS, dtype=float), indexing="ij")
    beyond = np.maximum(y - SEAM, 0)
    angle = np.radians(turn * (1 - ends * x / (ROWS - 1)))
    points = np.stack([x, y - beyond * (1 - np.cos(angle)), beyond * np.sin(angle)], axis=-1).reshape(-1, 3)
    a = (np.arange(ROWS - 1)[:, None] * COLUMNS + np.arange(COLUMNS - 1)).ravel()
    facets = np.concatenate(
        [np.stack([a, a + COLUMNS, a + COLUMNS + 1], 1), np.stack([a, a + COLUMNS + 1, a + 1], 1)]
    )
    if turned:
        far = (facets % COLUMNS).max(axis=1) > SEAM
        facets[far] = facets[far, ::-1]
    return sheet(facets, (1, 1) if kind == CRACK else (1, 2), kind, points)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("turn", [FOLD + 1, 90.0, -110.0])
def test_a_sharp_fold_of_the_crack_is_a_line_with_normals_of_its_own_on_either_side(turn, turned):
    surface = folded(turn, turned=turned)
    found = folded_patches(surface)
    far = (surface.facets % COLUMNS).max(axis=1) > SEAM
    assert (found.of_facet == (far if not far[0] else ~far)).all()
    assert found.of_facet[found.first_facet].tolist() == [0, 1]
    state = make_state(surface, np.ones(len(surface.points)))
    inner = [row * COLUMNS + SEAM for row in range(1, ROWS - 1)]
    assert (state.mesh.rank[inner] == 1).all()
    normals = unit_normals(surface.points, surface.facets)
    assert np.einsum("ij,ij->i", normals, state.guards.reference) == pytest.approx(1.0)
    assert (surface_of(state, surface).sides == 1).all()


@pytest.mark.parametrize(
    "surface",
    [folded(FOLD - 1), folded(90.0, kind=INTERFACE), folded(90.0, ends=True)],
    ids=["gentle", "boundary", "ending"],
)
def test_gentle_folds_and_folds_of_boundaries_and_folds_that_end_part_nothing(surface):
    assert (folded_patches(surface).of_facet == 0).all()


def with_trace(surface: Surface) -> Surface:
    """The crack goes into grain 2 a column beyond the fold, at a trace along it with points between its."""
    points = surface.points.copy()
    points[SEAM + 1 :: COLUMNS, 0] -= 0.5
    sides = np.where((surface.facets % COLUMNS).max(axis=1) > SEAM + 1, 2, 1)
    return Surface(points, surface.facets, np.stack([sides, sides], axis=1), surface.kind)


def uniform(l_min: float) -> Sizing:
    return Sizing(l_min, 10.0, 10.0, 0.0, 0.0, 1.0, np.zeros((0, 3)))


@pytest.mark.parametrize("l_min, length", [(0.5, PER_WIDTH), (4.0, 4.0)])
def test_edges_are_short_in_a_strip_between_fold_and_trace_and_longer_away(l_min, length):
    surface = with_trace(folded(90.0))
    found = short_beside_folds(surface, uniform(l_min))
    inner = [row * COLUMNS + SEAM + 1 for row in range(1, ROWS - 2)]
    lengths = found.at(surface.points[inner])
    assert lengths.min() == pytest.approx(length)
    # places are up to l_min / 2 apart, and lengths grow by half the distance
    assert lengths.max() <= length + 0.25 * l_min
    away = surface.points[inner] + [0.0, 0.0, 7.0]
    assert (found.at(away) > length + 6 * FREE_GROWTH * 0.99).all()


@pytest.mark.parametrize("surface", [folded(90.0), with_trace(folded(FOLD - 1))], ids=["alone", "gentle"])
def test_lengths_stay_without_a_strip_or_a_sharp_fold(surface):
    sizing = uniform(0.5)
    assert short_beside_folds(surface, sizing) is sizing

"""An inserted crack is held to the given one, and tried anew where it is off."""

from dataclasses import replace

import numpy as np
import pytest
from given_cracks import wavy_disc
from structured_box import structured_box

from craftmesh.cracks.crack_tolerances import AREA_KEPT, AREA_PROMISED, INSERTION
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.errors import CraftmeshError
from craftmesh.insertion.attempts import ATTEMPTS, Given, Inserted, soundest
from craftmesh.insertion.insert import insert_crack
from craftmesh.insertion.options import InsertOptions
from craftmesh.insertion.sheet import sheet_of
from craftmesh.insertion.snap import prepared
from craftmesh.sizing.sizing import Sizing, densify
from craftmesh.surface.front import front_edges
from craftmesh.surface.measure import area_vectors
from craftmesh.types import CRACK, Surface

BOX = np.array([[0.0, 0, 0], [8, 8, 8]])
L_MIN = 0.5


@pytest.fixture(scope="module")
def model() -> Surface:
    return structured_box((8, 8, 8), lambda c: 1 + (c[:, 0] > 4).astype(int))[0]


@pytest.fixture(scope="module")
def crack():
    points, triangles = wavy_disc(3.0, 1.0, rings=20)
    return crack_from_triangles(points + [4, 6, 4], triangles, None, BOX)


@pytest.fixture(scope="module")
def made(model, crack) -> Inserted:
    sources = np.concatenate([densify(crack.points[front], L_MIN / 2) for front in crack.fronts])
    surface, numbers = insert_crack(model, crack, Sizing(L_MIN, 1.0, 2.0, 4.0, 8.0, 1.0, sources))
    return Inserted(surface, surface.kind == CRACK, 0.0, numbers)


@pytest.fixture(scope="module")
def given(crack) -> Given:
    return Given(crack, BOX, L_MIN)


def with_point_moved(made: Inserted, point: int, way: np.ndarray) -> Inserted:
    points = made.surface.points.copy()
    points[point] += way
    return made._replace(surface=replace(made.surface, points=points))


def test_a_crack_that_came_in_well_is_nowhere_off(made, given):
    places, times, _ = given.misfit(made)
    assert len(places) == 0
    assert times <= 1


def test_a_node_off_the_given_surface_is_found_and_told_in_shares_of_what_is_allowed(made, given):
    front = front_edges(made.surface)
    inner = np.setdiff1d(made.surface.facets[made.own], front)
    deep = inner[np.argmin(np.linalg.norm(made.surface.points[inner] - [4, 6, 4], axis=1))]
    normal = area_vectors(
        made.surface.points, made.surface.facets[made.own & (made.surface.facets == deep).any(axis=1)]
    ).sum(axis=0)
    way = 2 * INSERTION.facets * L_MIN * normal / np.linalg.norm(normal)
    places, times, _ = given.misfit(with_point_moved(made, deep, way))
    assert times == pytest.approx(2, rel=0.1)
    assert (np.linalg.norm(places - made.surface.points[deep] - way, axis=1) < 2 * L_MIN).all()


def test_a_node_along_the_surface_off_the_front_is_found(made, given):
    node = front_edges(made.surface)[3, 0]
    inwards = np.array([4.0, 6.0, made.surface.points[node, 2]]) - made.surface.points[node]
    way = 3 * INSERTION.front * L_MIN * inwards / np.linalg.norm(inwards)
    places, times, _ = given.misfit(with_point_moved(made, node, way))
    assert times > 2
    assert np.linalg.norm(places - made.surface.points[node] - way, axis=1).min() < 1e-12


def test_area_that_is_not_there_is_missed_and_what_is_hidden_counts(made, given, crack):
    share = 3 * AREA_KEPT * AREA_PROMISED * given.area
    _, times, _ = given.misfit(made._replace(hidden=share))
    assert times == pytest.approx(3, abs=1.1)
    facets = np.flatnonzero(made.own)
    area = np.linalg.norm(area_vectors(made.surface.points, made.surface.facets[facets]), axis=1)
    lost = np.isin(np.arange(len(made.own)), facets[: 1 + np.searchsorted(np.cumsum(area), share)])
    kept = made._replace(own=made.own & ~lost)
    assert given.misfit(kept).times > 1


def attempts_at(model, crack, given, results):
    """Return the attempt chosen of those that the results make, and the options of each that was made."""
    sheet, asked = sheet_of(crack, BOX), []

    def insert(_, options):
        asked.append(options)
        result = results[min(len(asked), len(results)) - 1]
        if isinstance(result, CraftmeshError):
            raise result
        return result

    options = InsertOptions()
    return soundest(prepared(model, sheet), sheet, given, options, insert), asked


def test_a_sound_crack_takes_one_attempt(model, crack, given, made):
    best, asked = attempts_at(model, crack, given, [made])
    assert best.made is made
    assert asked == [InsertOptions()]


def test_a_crack_that_is_off_is_tried_with_smaller_facets_and_the_first_sound_one_taken(
    model, crack, given, made
):
    off = made._replace(hidden=5 * AREA_KEPT * AREA_PROMISED * given.area)
    best, asked = attempts_at(model, crack, given, [off, off, made])
    assert best.made is made
    assert len(asked) == 3
    assert len(best.cut.points) > len(model.points)


def test_a_crack_that_does_not_come_in_is_tried_with_other_choices(model, crack, given, made):
    crossing = CraftmeshError("a trace edge crosses another")
    best, asked = attempts_at(model, crack, given, [crossing, crossing, made])
    assert best.made is made
    assert len({(options.snap, options.snap_front) for options in asked}) == len(asked) == 3


def test_what_comes_in_by_no_choice_is_refused_with_what_the_last_said(model, crack, given):
    asked = []

    def refused(_, options):
        asked.append((options.snap, options.snap_front))
        raise CraftmeshError("the last" if len(asked) == ATTEMPTS else "another")

    sheet = sheet_of(crack, BOX)
    with pytest.raises(CraftmeshError, match="the last"):
        soundest(prepared(model, sheet), sheet, given, InsertOptions(), refused)
    assert len(set(asked)) == len(asked) == ATTEMPTS


def test_a_crack_that_is_far_off_in_every_attempt_is_refused_with_the_place(model, crack, given, made):
    far = made._replace(hidden=40 * AREA_KEPT * AREA_PROMISED * given.area)
    with pytest.raises(
        CraftmeshError, match=r"near \[.*\] the mesh would deviate by \d+ times the allowed"
    ):
        attempts_at(model, crack, given, [far])


def test_of_attempts_that_are_all_off_the_nearest_is_taken(model, crack, given, made):
    far, nearer = (made._replace(hidden=n * AREA_KEPT * AREA_PROMISED * given.area) for n in (9.0, 4.0))
    best, asked = attempts_at(model, crack, given, [far, nearer, far])
    assert best.made is nearer and len(asked) == ATTEMPTS

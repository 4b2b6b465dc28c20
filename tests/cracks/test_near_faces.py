"""A crack in or almost in a face of the box is refused before anything is meshed; others pass."""

from dataclasses import replace

import numpy as np
import pytest
from given_cracks import over_grid, wavy_disc
from structured_box import structured_box

from craftmesh.cli import main
from craftmesh.cracks.near_faces import along_faces, refuse_near_faces
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.series import prescribed_crack
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.errors import CraftmeshError
from craftmesh.insertion.insert import insert_crack
from craftmesh.io.npz import write_labels
from craftmesh.types import Voxels

BOX = np.array([[0.0, 0, 0], [20, 20, 20]])
L_MIN = 0.5


def tilted(degrees: float) -> tuple:
    return (0.0, np.sin(np.radians(degrees)), np.cos(np.radians(degrees)))


def penny(height: float, degrees: float, y: float = 10.0, radius: float = 5.0):
    options = CrackOptions(centre=(10.0, y, height), normal=tilted(degrees), radius=radius)
    return prescribed_crack(BOX, options)


@pytest.mark.parametrize("offset", [1e-4, 0.01, 0.19])
@pytest.mark.parametrize("top", [False, True])
def test_a_crack_parallel_to_a_face_is_refused_with_its_distance(offset, top):
    height = 20 - offset * L_MIN if top else offset * L_MIN
    (part,) = along_faces(penny(height, 0.0), BOX, L_MIN)
    assert part.face == ("ZMAX" if top else "ZMIN")
    # the front's chords lie within 1e-5 of the circle, and so its area within 2e-5
    assert part.area == pytest.approx(np.pi * 25, rel=1e-4)
    assert part.least == pytest.approx(offset * L_MIN) and part.most == pytest.approx(offset * L_MIN)


@pytest.mark.parametrize("offset", [0.21, 0.5, 3.0])
def test_a_parallel_crack_farther_from_the_face_passes(offset):
    assert along_faces(penny(offset * L_MIN, 0.0), BOX, L_MIN) == []


@pytest.mark.parametrize("degrees", [1e-3, 0.2, 1.0, 5.9])
def test_a_mouth_at_a_small_angle_is_refused_with_the_angle(degrees):
    (part,) = along_faces(penny(0.0, degrees), BOX, L_MIN)
    assert part.face == "ZMIN" and part.least == pytest.approx(0.0, abs=1e-9)
    assert part.tilt == pytest.approx(degrees, rel=1e-6)


@pytest.mark.parametrize("degrees", [6.1, 10.0, 45.0, 90.0])
def test_a_mouth_at_a_larger_angle_passes(degrees):
    assert along_faces(penny(0.0, degrees), BOX, L_MIN) == []


def test_edge_cracks_and_through_cracks_pass():
    edge = CrackOptions(shape="through_edge", centre=(0, 10, 7.0), radius=8.0)
    corner = CrackOptions(centre=(0, 0, 10.0), radius=8.0)
    wide = CrackOptions(centre=(10, 10, 10), radius=13.0, normal=(0.1, 0.2, 1.0))
    for options in (edge, corner, wide):
        assert along_faces(prescribed_crack(BOX, options), BOX, L_MIN) == []


def curved(lowest: float, amplitude: float):
    """A wavy disc whose lowest point is `lowest` above the lower face."""
    points, triangles = wavy_disc(6.0, amplitude, rings=20)
    points = points + [10.0, 10.0, lowest - points[:, 2].min()]
    return crack_from_triangles(points, triangles, None, BOX)


def test_a_curved_crack_is_measured_place_by_place():
    near = along_faces(curved(0.01, 1.0), BOX, L_MIN)
    assert [part.face for part in near] == ["ZMIN"]
    # only the troughs count: they are a small share of the area, 113
    assert L_MIN**2 < near[0].area < 20
    assert near[0].least == pytest.approx(0.01) and near[0].most <= 0.2 * L_MIN * (1 + 1e-9)
    assert along_faces(curved(0.5 * L_MIN, 1.0), BOX, L_MIN) == []


def test_a_part_outside_the_box_does_not_count():
    """A crack in the plane of the lower face's neighbour, but mostly beyond the box's side."""
    crack = penny(0.01, 0.0, y=24.9, radius=5.0)
    # a segment of height 0.1: its area is 4 / 3 * 0.1 * sqrt(2 * 5 * 0.1 / 2), about 0.13
    assert along_faces(crack, BOX, L_MIN) == []
    assert len(along_faces(crack, BOX, 0.1)) == 1


def test_the_message_names_face_distance_angle_and_remedy():
    with pytest.raises(CraftmeshError, match=r"0.05 from the box face ZMIN.*.0.1.: move it inward by 0.05"):
        refuse_near_faces(penny(0.05, 0.0), BOX, L_MIN)
    with pytest.raises(CraftmeshError, match=r"ZMIN, at 1 degrees.*angle of 6 degrees or more.*: turn it"):
        refuse_near_faces(penny(0.0, 1.0), BOX, L_MIN)


def test_the_insertion_holds_a_crack_against_the_lengths_it_is_given():
    """At the crack's own stage l_min may not be known: here an edge is 1."""
    model, _ = structured_box((8, 8, 8), lambda c: np.ones(len(c), int))
    box = np.array([[0.0, 0, 0], [8, 8, 8]])
    options = CrackOptions(centre=(4, 4, 0.15), radius=2.5)
    with pytest.raises(CraftmeshError, match="from the box face ZMIN"):
        insert_crack(model, prescribed_crack(box, options), None)
    higher = replace(options, centre=(4, 4, 0.5))
    assert insert_crack(model, prescribed_crack(box, higher), None)[1]["crack_facets"] > 0


@pytest.mark.parametrize(("lengths", "refused"), [([], True), (["--l-min", "0.2"], False)])
def test_the_command_takes_l_min_and_else_half_a_voxel(tmp_path, capsys, lengths, refused):
    write_labels(tmp_path / "labels.npz", Voxels(np.ones((9, 9, 9), int), (1, 1, 1), (0, 0, 0)))
    crack = ["--centre", "4.5", "4.5", "0.08", "--radius", "3"]
    words = ["crack", str(tmp_path / "labels.npz"), *crack, *lengths, "-o", str(tmp_path / "crack.vtp")]
    assert main(words) == int(refused)
    assert (tmp_path / "crack.vtp").exists() != refused
    assert ("box face ZMIN" in capsys.readouterr().err) == refused


def test_a_front_along_a_face_is_refused_but_not_one_that_ends_there():
    square = np.array([[-1, -1, 5], [9.97, -1, 5], [9.97, 11, 5], [-1, 11, 5]], float)
    box = np.array([[0.0, 0.0, 0.0], [10.0, 10.0, 10.0]])
    crack = crack_from_triangles(square, [[0, 1, 2], [0, 2, 3]], None, box)
    with pytest.raises(CraftmeshError, match="front runs 0.03 from the box face XMAX over a length of 10"):
        refuse_near_faces(crack, box, 1.0)
    refuse_near_faces(crack, box, 0.05)
    square[2, 0] = 8.0
    slanted = crack_from_triangles(square, [[0, 1, 2], [0, 2, 3]], None, box)
    refuse_near_faces(slanted, box, 1.0)


def roof(beside: float, slope: float):
    """A crack kinked along a line beside x = 0, whose sides go inward from there."""
    y, profile = np.linspace(-1, 21, 12), np.array([[14.0, -1.0], [0.0, 10.0], [8.0, 14.0]])
    x = profile[:, :1] + beside * L_MIN + slope * (y - 10)
    z = np.broadcast_to(profile[:, 1:], x.shape)
    return crack_from_triangles(*over_grid(x, np.broadcast_to(y, x.shape), z), None, BOX)


@pytest.mark.parametrize("beside, slope", [(0.09, 0.0), (0.05, 0.003)])
def test_a_kink_along_a_face_is_refused(beside, slope):
    with pytest.raises(CraftmeshError, match="kink runs .* from the box face XMIN"):
        refuse_near_faces(roof(beside, slope), BOX, L_MIN)


@pytest.mark.parametrize("beside, slope", [(0.11, 0.0), (-0.11, 0.0), (0.0, 0.05), (10.0, 0.0)])
def test_a_kink_away_from_a_face_or_across_it_passes(beside, slope):
    refuse_near_faces(roof(beside, slope), BOX, L_MIN)


def test_a_crack_that_cuts_next_to_nothing_off_a_corner_of_the_box_lies_outside():
    points = np.array([[10.0, -5, -5], [-5, 10, -5], [-5, -5, 10]]) + 1e-9
    with pytest.raises(CraftmeshError, match="outside the box"):
        crack_from_triangles(points, np.array([[0, 1, 2]]), None, BOX)
    assert len(crack_from_triangles(points + 0.1, np.array([[0, 1, 2]]), None, BOX).triangles)


@pytest.mark.parametrize("depth", [0.05, 0.15, 0.19, 0.21, 0.25])
@pytest.mark.parametrize("at_x, at_z", [(0, 0), (0, 1), (1, 0), (1, 1)])
def test_a_crack_that_cuts_off_less_than_a_fifth_of_l_min_along_an_edge_is_refused(depth, at_x, at_z):
    # across an edge along y: its middle is deepest, at the same distance from both faces
    place, inward = depth * L_MIN, np.array([1.0 - 2 * at_x, 0.0, 1.0 - 2 * at_z])
    centre = np.array([20.0 * at_x, 10.0, 20.0 * at_z]) + place * inward
    options = CrackOptions(centre=tuple(centre), normal=tuple(inward), axis=(0, 1, 0), radius=5.0)
    crack = prescribed_crack(BOX, options)
    if depth < 0.2:
        with pytest.raises(CraftmeshError, match="cuts only a sliver off the box.*nearer than 0.2 l_min"):
            refuse_near_faces(crack, BOX, L_MIN)
    else:
        refuse_near_faces(crack, BOX, L_MIN)


def beside_an_edge(distance: float, degrees: float, length: float = 14.0):
    """A crack whose mouth on ZMIN runs `distance` (in l_min) from XMIN, from which it goes at an angle."""
    turn = np.radians(degrees)
    way, along = np.array([np.sin(turn), 0, np.cos(turn)]), np.array([0, length, 0])
    start = np.array([distance * L_MIN, 3.0, 0.0]) - 3 * way
    corners = np.array([start, start + along, start + along + 12 * way, start + 12 * way])
    return crack_from_triangles(corners, np.array([[0, 1, 2], [0, 2, 3]]), None, BOX)


@pytest.mark.parametrize("degrees", [7.0, 12.0, 20.0, 45.0])
def test_a_mouth_beside_an_edge_of_the_box_passes_from_a_tenth_of_l_min_or_at_the_edge(degrees):
    for distance in (0.11, 0.15, 0.3):
        refuse_near_faces(beside_an_edge(distance, degrees), BOX, L_MIN)
    for distance in (0.02, 0.06, 0.09):
        with pytest.raises(CraftmeshError, match="XMIN"):
            refuse_near_faces(beside_an_edge(distance, degrees), BOX, L_MIN)


def test_a_ribbon_is_refused_for_its_length_and_not_where_the_mouth_is_at_the_edge():
    refuse_near_faces(beside_an_edge(0.01, 20.0), BOX, L_MIN)
    refuse_near_faces(beside_an_edge(0.05, 45.0, length=7.9 * L_MIN), BOX, L_MIN)
    with pytest.raises(CraftmeshError, match="mouth runs 0.025 from the box face XMIN .* 0.0?25"):
        refuse_near_faces(beside_an_edge(0.05, 45.0, length=8.1 * L_MIN), BOX, L_MIN)

"""Cracks of every shape: their fronts, their growth, and surfaces from files."""

import numpy as np
import pytest
import vtk_objects
from given_cracks import wavy_disc
from hypothesis import given, settings
from hypothesis import strategies as st
from surface_writer import write_triangles

from craftmesh.commands.crack import given_surface
from craftmesh.cracks.check_crack import check_crack
from craftmesh.cracks.options import CrackOptions, crack_files
from craftmesh.cracks.series import crack_of_increment, prescribed_crack, refuse_shrunk
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.errors import CraftmeshError
from craftmesh.insertion.sheet import sheet_of
from craftmesh.io.surface_files import SUFFIXES
from craftmesh.surface.measure import area_vectors
from craftmesh.types import Crack

BOX = np.array([[1.0, -2.0, 3.0], [11.0, 10.0, 14.0]])
CENTRE = tuple(BOX.mean(axis=0))


def area(crack) -> float:
    return np.linalg.norm(area_vectors(crack.points, crack.triangles), axis=1).sum()


def box_distance(points) -> np.ndarray:
    return np.abs(points[:, None] - BOX[None]).min(axis=(1, 2))


def test_a_penny_inside_the_box_has_one_closed_front_on_its_circle():
    crack = prescribed_crack(BOX, CrackOptions(centre=CENTRE, radius=3.0, normal=(1, 2, 3)))
    (front,) = crack.fronts
    assert front[0] == front[-1]
    distance = np.linalg.norm(crack.points[front] - CENTRE, axis=1)
    assert np.allclose(distance, 3.0, rtol=1e-12)
    middle = (crack.points[front[1:]] + crack.points[front[:-1]]) / 2
    assert (3.0 - np.linalg.norm(middle - CENTRE, axis=1)).max() <= 1e-4 * 3.0
    assert area(crack) == pytest.approx(9 * np.pi, rel=1e-4)
    assert check_crack(crack) == []


@pytest.mark.parametrize(
    ("centre", "fronts", "planes"),
    [
        ((6.0, -2.0, 8.0), 1, [(1, 0), (1, 0)]),
        ((1.0, -2.0, 8.0), 1, [(0, 0), (1, 0)]),
        ((11.0, 10.0, 8.0), 1, [(0, 1), (1, 1)]),
    ],
)
def test_semi_and_quarter_ellipses_end_exactly_on_the_box(centre, fronts, planes):
    options = CrackOptions(shape="ellipse", centre=centre, semi_axes=(4.0, 2.5), normal=(0.1, 0.05, 1))
    crack = prescribed_crack(BOX, options)
    assert len(crack.fronts) == fronts
    (front,) = crack.fronts
    ends = crack.points[front[[0, -1]]]
    assert all(any(end[axis] == BOX[side, axis] for end in ends) for axis, side in planes)
    inner = crack.points[front[1:-1]]
    assert (inner >= BOX[0]).all() and (inner <= BOX[1]).all()


def test_a_penny_wider_than_the_box_has_a_front_per_corner_it_reaches():
    crack = prescribed_crack(BOX, CrackOptions(centre=CENTRE, radius=6.5))
    assert len(crack.fronts) == 4
    ends = crack.points[[front[i] for front in crack.fronts for i in (0, -1)]]
    assert (box_distance(ends) == 0).all()


def test_a_through_edge_crack_runs_straight_across_the_box():
    options = CrackOptions(
        shape="through_edge", centre=(1, 4, 8), normal=(0, 0, 1), axis=(1, 0, 0), radius=4.0
    )
    crack = prescribed_crack(BOX, options)
    (front,) = crack.fronts
    ends = crack.points[front[[0, -1]]]
    assert np.allclose(np.sort(ends, axis=0), [[5.0, -2.0, 8.0], [5.0, 10.0, 8.0]], atol=1e-12)
    assert set(ends[:, 1]) == {-2.0, 10.0}


def test_growth_adds_to_the_sizes_and_lists_replace_it():
    grown = CrackOptions(centre=CENTRE, radius=2.0, growth=0.5)
    listed = CrackOptions(shape="ellipse", centre=CENTRE, increments=((2.0, 1.0), (3.0, 1.5)))
    assert area(prescribed_crack(BOX, grown, 2)) == pytest.approx(9 * np.pi, rel=1e-4)
    assert area(prescribed_crack(BOX, listed, 1)) == pytest.approx(4.5 * np.pi, rel=1e-4)
    with pytest.raises(CraftmeshError, match="none for increment 2"):
        prescribed_crack(BOX, listed, 2)


@pytest.mark.parametrize(
    "values",
    [
        {"radius": 0.0},
        {"radius": -1.0},
        {"radius": float("nan")},
        {},
        {"radius": 1.0, "normal": (0, 0, 0)},
        {"radius": 1.0, "centre": (0, float("nan"), 1)},
        {"semi_axes": (2.0, 1.0), "axis": (0, 0, 2)},
        {"radius": 1.0, "axis": (0, 0, 0)},
        {"radius": 1.0, "centre": (100, 0, 0)},
        {"radius": 1.0, "centre": (6, 4, 14.0)},
        {"radius": 1.0, "shape": "square"},
    ],
)
def test_bad_cracks_are_refused_in_one_line(values):
    with pytest.raises(CraftmeshError) as error:
        prescribed_crack(BOX, CrackOptions(**{"centre": CENTRE, **values}))
    assert "\n" not in str(error.value)


def test_folded_nonmanifold_and_self_crossing_surfaces_are_refused():
    square = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]], float) + [3, 2, 8]
    folded = np.vstack([square, square[:2] + [0, 1.0, 0.5]])
    with pytest.raises(CraftmeshError, match="folded"):
        crack_from_triangles(folded, [[0, 1, 2], [0, 2, 3], [3, 2, 5], [3, 5, 4]], None, BOX)
    fan = np.vstack([square, [[5.0, 1.0, 8.5]]])
    with pytest.raises(CraftmeshError, match="manifold|folded"):
        crack_from_triangles(fan, [[0, 1, 2], [0, 2, 3], [0, 2, 4]], None, BOX)
    with pytest.raises(CraftmeshError, match="finite"):
        crack_from_triangles(square * np.nan, [[0, 1, 2]], None, BOX)


def test_given_fronts_choose_among_the_boundary_edges():
    points, triangles = wavy_disc(3.0, 0.2)
    points = points + CENTRE
    rim = points[-48:]
    crack = crack_from_triangles(points, triangles, [rim[:20]], BOX)
    (front,) = crack.fronts
    assert sorted(map(tuple, crack.points[front])) == sorted(map(tuple, rim[:20]))
    assert check_crack(crack) == []


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_surface_from_a_file_is_joined_and_keeps_its_area(tmp_path, suffix):
    points, triangles = wavy_disc(3.0, 0.3)
    write_triangles(tmp_path / f"crack{suffix}", points + CENTRE, triangles)
    options = CrackOptions(shape="surface", file=str(tmp_path / f"crack{suffix}"))
    crack = crack_of_increment(options, 0, BOX, given_surface(options, 0, BOX)[0])
    assert len(crack.points) == len(points) and len(crack.fronts) == 1
    # float32 coordinates of some of the files
    assert area(crack) == pytest.approx(
        np.linalg.norm(area_vectors(points, triangles), axis=1).sum(), rel=1e-5
    )


def write_plain(path, points, triangles, **point_data):
    """Write a .vtp of triangles as other programs do: no lines, and any point data."""
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    poly = vtkPolyData()
    poly.SetPoints(vtk_objects.vtk_points(points))
    poly.SetPolys(vtk_objects.uniform_cells(triangles))
    vtk_objects.add_arrays(poly.GetPointData(), point_data)
    vtk_objects.write_dataset(path, poly, "PolyData")


@pytest.mark.parametrize("arrays", [(), ("uv", "Normals")])
def test_a_plain_vtp_is_read_whatever_arrays_it_has(tmp_path, arrays):
    points, triangles = wavy_disc(3.0, 0.3)
    extra = {name: np.ones((len(points), 3)) for name in arrays}
    write_plain(tmp_path / "crack.vtp", points + CENTRE, triangles, **extra)
    options = CrackOptions(shape="surface", file=str(tmp_path / "crack.vtp"))
    crack = crack_of_increment(options, 0, BOX, given_surface(options, 0, BOX)[0])
    expected = crack_from_triangles(points + CENTRE, triangles, None, BOX)
    assert np.array_equal(crack.points, expected.points)
    assert np.array_equal(crack.triangles, expected.triangles)
    assert np.array_equal(crack.fronts[0], expected.fronts[0])


def test_a_given_front_goes_before_the_boundary(tmp_path):
    points, triangles = wavy_disc(3.0, 0.2)
    rim = points[-48:] + CENTRE
    lines = ["x,y,z", *(",".join(map(repr, row)) for row in rim[:20].tolist())]
    (tmp_path / "front.csv").write_text("\n".join(lines))
    write_plain(tmp_path / "crack.vtp", points + CENTRE, triangles)
    options = CrackOptions(
        shape="surface", file=str(tmp_path / "crack.vtp"), front=str(tmp_path / "front.csv")
    )
    (front,) = crack_of_increment(options, 0, BOX, given_surface(options, 0, BOX)[0]).fronts
    assert len(front) == 20


def test_files_of_an_increment_are_named_by_their_option():
    series = CrackOptions(shape="surface", file="a.stl", increments=("b.stl", "c.vtp"), front="f.csv")
    assert crack_files(series, 1) == {"increments": "c.vtp", "front": "f.csv"}
    assert crack_files(CrackOptions(shape="surface", file="a.stl"), 3) == {"file": "a.stl"}
    assert crack_files(CrackOptions(increments=(1.0, 2.0)), 1) == {}
    with pytest.raises(CraftmeshError, match="none for increment 2"):
        crack_files(series, 2)


def test_a_crack_that_shrinks_is_refused():
    small, large = (prescribed_crack(BOX, CrackOptions(centre=CENTRE, radius=r)) for r in (2.0, 2.0 + 1e-6))
    refuse_shrunk(large, small, 1)
    refuse_shrunk(large, large, 1)
    with pytest.raises(CraftmeshError, match="increment 1: its area .* does not shrink"):
        refuse_shrunk(small, large, 1)


def test_each_breach_of_a_crack_is_told():
    square = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0], [2, 2, 0]], float)
    fan = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
    rim = np.array([0, 1, 2, 3, 0])
    assert check_crack(Crack(square, fan, (rim,))) == []
    outside = square + [0, 0, 0]
    outside[4] = 2, 5, 0  # past an edge of the square: one triangle of the fan is turned over
    breaches = {
        "1 triangles are reversed": Crack(outside, fan, (rim,)),
        "no triangles": Crack(square, np.zeros((0, 3)), ()),
        "4 triangles have no area": Crack(square * 0, fan, (rim,)),
        "1 triangles have no area": Crack(square, [*fan.tolist(), [0, 1, 1]], (rim,)),
        "front 2 has 1 edges": Crack(square, fan, (rim[:3], np.array([3, 0, 4]))),
    }
    for sentence, crack in breaches.items():
        assert any(sentence in breach for breach in check_crack(crack)), sentence


def test_a_crack_past_the_box_on_all_sides_has_no_front_and_one_beside_it_is_refused():
    square = np.array([[-9, -9, 4], [99, -9, 4], [99, 99, 4], [-9, 99, 4]], float)
    crack = crack_from_triangles(square, [[0, 1, 2], [0, 2, 3]], None, BOX)
    assert crack.fronts == () and check_crack(crack) == []
    foot, number, _ = sheet_of(crack, BOX).rim.nearest_front(np.zeros((2, 2)))
    assert np.isinf(foot).all() and (number == -1).all()
    with pytest.raises(CraftmeshError, match="outside the box"):
        crack_from_triangles(square + [0, 0, 999], [[0, 1, 2], [0, 2, 3]], None, BOX)
    with pytest.raises(CraftmeshError, match="no boundary edge .* in the box .* along the given front"):
        crack_from_triangles(square, [[0, 1, 2], [0, 2, 3]], [square[:2]], BOX)


def test_a_mouth_on_the_box_is_pushed_out_so_that_the_box_is_inside_and_what_is_farther_out_is_not():
    square = np.array([[1, 2, 8], [5, 2, 8], [5, 6, 8], [1, 6, 8]], float)
    crack = crack_from_triangles(square, [[0, 1, 2], [0, 2, 3]], None, BOX)
    sheet = sheet_of(crack, BOX)
    assert (sheet.rim.inside(sheet.uv(np.array([[1.0, 4.0, 8.0], [0.999, 4.0, 8.0]]))) > 0.5).all()
    assert (sheet.rim.inside(sheet.uv(np.array([[5.5, 4, 8], [3, 1.5, 8], [0.5, 4, 8]]))) < 0).all()


@settings(max_examples=15)
@given(
    normal=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda n: np.linalg.norm(n) > 0.1),
    radius=st.floats(0.5, 3.5),
    seed=st.integers(0, 1000),
)
def test_the_sheet_of_a_penny_is_exact(normal, radius, seed):
    axis = np.eye(3)[np.argmin(np.abs(normal))]
    options = CrackOptions(centre=CENTRE, radius=radius, normal=normal, axis=tuple(axis))
    sheet = sheet_of(prescribed_crack(BOX, options), BOX)
    points = np.random.default_rng(seed).uniform(*BOX, size=(50, 3))
    unit = np.array(normal) / np.linalg.norm(normal)
    offset = (points - CENTRE) @ unit
    foot = points - offset[:, None] * unit
    assert np.allclose(sheet.offset(points), offset, atol=1e-12)
    assert np.allclose(sheet.lift(sheet.uv(points)), foot, atol=1e-12)
    exact = radius - np.linalg.norm(foot - CENTRE, axis=1)
    assert np.allclose(sheet.rim.inside(sheet.uv(points)), exact, atol=2e-5 * radius)


def test_the_sheet_of_a_curved_crack_passes_through_its_points_and_goes_on_past_the_front():
    points, triangles = wavy_disc(3.0, 0.4)
    crack = crack_from_triangles(points + CENTRE, triangles, None, BOX)
    sheet = sheet_of(crack, BOX)
    assert not sheet.planar
    assert np.abs(sheet.offset(crack.points)).max() < 1e-12
    rim = crack.points[crack.fronts[0]]
    past = CENTRE + (rim - CENTRE) * 1.05
    # the slope's change over 5% of the radius, at most amplitude * (2 / radius)^2 * (0.15)^2
    assert np.abs(sheet.offset(past)).max() < 0.05
    assert (sheet.rim.inside(sheet.uv(past)) < 0).all()


@pytest.mark.parametrize("normal", [(1, 0, 0), (-2, 0, 0), (0, 1, 0)])
def test_a_round_crack_may_lie_square_to_its_axis(normal):
    crack = prescribed_crack(BOX, CrackOptions(shape="penny", centre=CENTRE, normal=normal, radius=2.0))
    assert area(crack) == pytest.approx(np.pi * 4, rel=1e-3)
    assert np.abs((crack.points - CENTRE) @ normal).max() < 1e-12

"""Growth along slip planes: the direction of one grain is known, whatever its orientation."""

from dataclasses import replace

import numpy as np
import pytest

from craftmesh.errors import CraftmeshError
from craftmesh.growth.extension import kinks_and_extensions
from craftmesh.growth.front_points import FrontPoints
from craftmesh.growth.options import GrowthOptions
from craftmesh.growth.slip_planes import SlipField, plane_activity, slip_kink_angles
from craftmesh.io.model_tables import OCTAHEDRAL, read_slip_table
from craftmesh.mechanics.materials import COMPONENT
from craftmesh.mechanics.orientation import quaternion_to_matrix, random_orientations
from craftmesh.mesh.front_frames import FrontFrames

PLANES = np.array([[1, 1, 1], [-1, 1, 1], [1, -1, 1], [1, 1, -1]])
SYSTEMS = [
    (n, b)
    for n in PLANES
    for b in ([0, 1, -1], [0, 1, 1], [1, 0, -1], [1, 0, 1], [1, -1, 0], [1, 1, 0])
    if np.dot(n, b) == 0
]

SLIP = GrowthOptions(criterion="slip", slip_table="slip.csv")  # with the default ring of 2 edges


def by(parameter):
    """Return options of growth by a slip parameter, Fatemi and Socie's with k = 0.5 and sigma_y = 200."""
    constants = {"fatemi_socie_k": 0.5, "cyclic_yield_stress": 200.0} if parameter == "fatemi_socie" else {}
    return replace(SLIP, slip_parameter=parameter, **constants)


def frames(count=3):
    """A straight front along y, the crack in the plane z = 0 and ahead of it x."""
    numbers = np.zeros(count, int)
    points = np.arange(count)[:, None] * [0.0, 1.0, 0.0]
    axes = [np.repeat([axis], count, axis=0).astype(float) for axis in ((0, 1, 0), (0, 0, 1), (1, 0, 0))]
    size = np.ones(count)
    return FrontFrames(points[:, 1], points, *axes, *(numbers,) * 7, np.full(count, "", object), size)


def cloud():
    """Points that fill the room round the front."""
    grid = np.moveaxis(np.mgrid[-3:3.1:0.5, -1:3.1:0.5, -3:3.1:0.5], 0, -1)
    return grid.reshape(-1, 3)


def resolved(turn):
    """Return the largest shear stress on each plane under tension along z, by Schmid."""
    shear = np.zeros(4)
    for n, b in SYSTEMS:
        own = abs((turn @ n)[2] * (turn @ b)[2]) / np.sqrt(6)
        plane = int((np.abs(PLANES @ n) == 3).argmax())
        shear[plane] = max(shear[plane], own)
    return shear


@pytest.mark.parametrize("seed", range(8))
def test_one_grain_in_tension_cracks_along_its_plane_of_greatest_shear(seed):
    turn = quaternion_to_matrix(random_orientations(1, np.random.default_rng(seed)))[0]
    shear, points = resolved(turn), cloud()
    field = SlipField(points, PLANES, np.tile(shear, (len(points), 1)))
    angle = slip_kink_angles(frames(), np.repeat(turn[None], 3, axis=0), field, SLIP)
    normal = turn @ PLANES[shear.argmax()] / np.sqrt(3)
    way = np.array([np.cos(angle[0]), 0, np.sin(angle[0])])
    assert abs(way @ normal) < 1e-12 and abs(angle[0]) <= np.radians(95)
    assert np.ptp(angle) == 0


def turned(binormal, normal):
    """Return the rotation whose crystal directions lie along binormal (x) and normal (z)."""
    x, z = (np.array(v) / np.linalg.norm(v) for v in (binormal, normal))
    return np.array([x, np.cross(z, x), z])


def test_where_two_planes_slip_alike_the_side_of_the_ring_that_slips_more_decides():
    turn = turned([1, 1, 0], [0, 0, 1])  # (111) and (11-1) hold the front, 54.74 degrees down and up
    points = cloud()
    slip = np.ones((len(points), 4)) * [1, 0, 0, 1]
    slip[points[:, 2] > 0] *= 1.1
    turns = np.repeat(turn[None], 3, axis=0)
    angle = slip_kink_angles(frames(), turns, SlipField(points, PLANES, slip), SLIP)
    assert np.degrees(angle) == pytest.approx(np.degrees(np.arctan(np.sqrt(2))))
    slip[:, 0] *= 2
    angle = slip_kink_angles(frames(), turns, SlipField(points, PLANES, slip), SLIP)
    assert np.degrees(angle) == pytest.approx(-np.degrees(np.arctan(np.sqrt(2))))
    assert not slip_kink_angles(frames(), turns, SlipField(points, PLANES, 0 * slip), SLIP).any()


def test_a_point_reads_only_its_own_grain():
    """Above z = 0 lies grain 2, whose slip turns the front upwards; grain 1 slips on the plane down."""
    turn = turned([1, 1, 0], [0, 0, 1])  # (111) and (11-1) hold the front, 54.74 degrees down and up
    points = cloud()
    grain = np.where(points[:, 2] > 0, 2, 1)
    slip = np.where(grain[:, None] == 2, [5.0, 0, 0, 5.0], [2.0, 0, 0, 1.0])
    turns, down = np.repeat(turn[None], 3, axis=0), np.degrees(np.arctan(np.sqrt(2)))
    for own, known, angle in ((1, grain, -down), (1, None, down), (2, grain, down), (3, grain, 0)):
        field = SlipField(points, PLANES, slip, known)
        found = slip_kink_angles(frames(), turns, field, SLIP, np.full(3, own))
        assert np.degrees(found) == pytest.approx(angle)


def test_growth_takes_the_angles_and_a_ring_without_points_is_refused():
    options = replace(SLIP, share=0.25)
    k, ways = np.tile([1.0, 0.1, 0], (2, 1)), np.radians([50.0, -50.0])
    found, _ = kinks_and_extensions(FrontPoints.of(k, 4.0, slip_angle=ways), options)
    assert np.array_equal(found.kink_angle, ways) and (found.extension == 1.0).all()
    with pytest.raises(CraftmeshError, match="grow.criterion is slip"):
        kinks_and_extensions(FrontPoints.of(k, 4.0), options)
    with pytest.raises(CraftmeshError, match="^slip_table: has no point within 1 of"):
        slip_kink_angles(
            frames(), np.tile(np.eye(3), (3, 1, 1)), SlipField(PLANES * 9.0, PLANES, np.eye(4)), SLIP
        )
    in_mm = SlipField((PLANES + frames().points[0]) * 1e3, PLANES, np.eye(4))
    with pytest.raises(
        CraftmeshError, match=r"the front from .*about 1000 times as large \(um beside mm\?\)"
    ):
        slip_kink_angles(frames(), np.tile(np.eye(3), (3, 1, 1)), in_mm, SLIP)
    with pytest.raises(CraftmeshError, match="criterion is slip and slip_table ''"):
        GrowthOptions(criterion="slip")


def test_tables_name_planes_or_stand_for_all_octahedral_ones(tmp_path):
    path = tmp_path / "slip.csv"
    path.write_text("x,y,z,slip_111,slip_1-11,slip_001\n0,0,0,1,2,3\n")
    found = read_slip_table(path)
    assert (
        found.grain is found.directions is found.stress is None
        and found.normals.tolist() == [[1, 1, 1], [1, -1, 1], [0, 0, 1]]
        and found.slip.tolist() == [[1, 2, 3]]
    )
    path.write_text("x,y,z,grain,slip\n0,0,0,7,1\n")
    found = read_slip_table(path)
    assert found.grain.tolist() == [7]
    assert len(found.normals) == len(OCTAHEDRAL) == 4 and found.slip.tolist() == [[1, 1, 1, 1]]
    path.write_text("x,y,z,strain\n0,0,0,1\n")
    with pytest.raises(CraftmeshError, match="expected x, y, z, and slip or"):
        read_slip_table(path)
    for header, text in (
        ("slip_111,slip_111_0-11", "planes and slip_hkl_uvw of systems"),
        ("slip_000", "slip_000 is not a plane"),
        ("slip_111_011", "slip_111_011 is not a plane, or a plane and a direction in it"),
    ):
        path.write_text(f"x,y,z,{header}\n0,0,0" + ",1" * len(header.split(",")) + "\n")
        with pytest.raises(CraftmeshError, match=text):
            read_slip_table(path)


def table_of_systems(folder):
    """Return the field of a table with one row: two systems of (111), one of (1-11), and a stress."""
    path = folder / "systems.csv"
    names = "x,y,z,grain,slip_111_-101,slip_111_0-11,slip_1-11_110,sxx,syy,szz,sxy,sxz,syz"
    path.write_text(f"{names}\n0,0,0,1,0.004,0.001,0.002,300,0,0,0,0,30\n")
    return SlipField(**read_slip_table(path)._asdict())


# By hand, stresses in MPa. On (111), n = (1, 1, 1) / sqrt 3: t = (300, 30, 30) / sqrt 3, t n = 120;
# t along [-101] is -270 / sqrt 6, and 0 along [0-11]. On (1-11): t = (300, 30, -30) / sqrt 3, t n = 80;
# t along [110] is 330 / sqrt 6.
@pytest.mark.parametrize(
    ("parameter", "known"),
    [
        ("slip", (0.005, 0.002)),
        ("fatemi_socie", (0.002 * (1 + 0.5 * 120 / 200), 0.001 * (1 + 0.5 * 80 / 200))),
        ("energy", (0.004 * 270 / np.sqrt(6), 0.002 * 330 / np.sqrt(6))),
    ],
)
def test_parameters_of_planes_are_those_by_hand_in_a_crystal_turned_with_its_stress(
    parameter, known, tmp_path
):
    field, options = table_of_systems(tmp_path), by(parameter)
    turn = quaternion_to_matrix(random_orientations(1, np.random.default_rng(3)))[0]
    turned_stress = turn @ field.stress[0, COMPONENT] @ turn.T
    rows, columns = [0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]
    for one, way in (
        (field, np.eye(3)),
        (replace(field, stress=turned_stress[rows, columns][None]), turn),
    ):
        found = [
            plane_activity(one, np.array([0]), np.array(systems), way, options)[0]
            for systems in ([0, 1], [2])
        ]
        assert found == pytest.approx(known)


def test_compression_of_a_plane_counts_as_no_normal_stress(tmp_path):
    field = table_of_systems(tmp_path)
    pressed = replace(field, stress=-field.stress)
    found = plane_activity(pressed, np.array([0]), np.array([0, 1]), np.eye(3), by("fatemi_socie"))
    assert found == pytest.approx([0.002])


@pytest.mark.parametrize("parameter", ["slip", "fatemi_socie", "energy"])
def test_no_parameter_reads_beyond_the_grain_boundary(parameter):
    """The plane down is read 1.63 below the front, the boundary is at 1: points on both sides are near."""
    turn = turned([1, 1, 0], [0, 0, 1])  # (111) and (11-1) hold the front, 54.74 degrees down and up
    points = cloud()
    grain = np.where(points[:, 2] >= -1, 2, 1)
    is_own = (grain == 1)[:, None]
    slip, stress = np.where(is_own, [1e-3, 1e-3], np.nan), np.where(is_own, [0, 0, 100.0, 0, 0, 0], np.nan)
    directions = np.array([[1, 1, -2], [1, 1, 2]])
    field = SlipField(points, np.array([[1, 1, 1], [1, 1, -1]]), slip, grain, directions, stress)
    turns, angle = np.repeat(turn[None], 3, axis=0), np.degrees(np.arctan(np.sqrt(2)))
    found = slip_kink_angles(frames(), turns, field, by(parameter), np.ones(3, int))
    assert np.degrees(found) == pytest.approx(-angle)
    blind = replace(field, grain=None)  # a mean over both grains is NaN, and no plane counts
    assert not slip_kink_angles(frames(), turns, blind, by(parameter), np.ones(3, int)).any()


def test_missing_columns_and_contradicting_options_are_named():
    field, turns = SlipField(cloud(), PLANES, np.ones((len(cloud()), 4))), np.tile(np.eye(3), (3, 1, 1))
    with pytest.raises(
        CraftmeshError, match="^slip_table: has no columns of the stress sxx, .*, syz; grow"
    ):
        slip_kink_angles(frames(), turns, field, by("fatemi_socie"))
    with pytest.raises(CraftmeshError, match="stress sxx, .* and slip_hkl_uvw of each system, .* energy"):
        slip_kink_angles(frames(), turns, field, by("energy"))
    with pytest.raises(CraftmeshError, match="slip_parameter is energy, but criterion is straight"):
        GrowthOptions(criterion="straight", slip_parameter="energy")
    for given in ({"slip_parameter": "fatemi_socie", "fatemi_socie_k": 1.0}, {"cyclic_yield_stress": 1.0}):
        with pytest.raises(CraftmeshError, match="give both numbers with slip_parameter fatemi_socie"):
            replace(SLIP, **given)

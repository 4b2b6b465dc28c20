"""Cracks in other units or places than the volume, and fits that are off what they are fitted to."""

import json

import numpy as np
import pytest
from skimage.measure import marching_cubes
from surface_writer import write_triangles

from craftmesh.cli import main
from craftmesh.cracks.fit_bounds import notes_on_size, refuse_other_place
from craftmesh.cracks.fitted_surface import crack_through_points
from craftmesh.cracks.one_sheet import sides_apart
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.cracks.two_sided import middle_sheet
from craftmesh.cracks.voxel_crack import crack_through_voxels
from craftmesh.errors import CraftmeshError
from craftmesh.io.npz import write_labels
from craftmesh.io.vtk import write_crack
from craftmesh.surface.measure import span_of, total_area
from craftmesh.surface.side_data import unit_hint
from craftmesh.types import Crack, Voxels

BOX = np.array([[0.0, 0, 0], [16, 16, 16]])
RING = np.linspace(0, 2 * np.pi, 41)
FRONT = np.stack([8 + 4 * np.cos(RING), 8 + 4 * np.sin(RING), 8 + 0 * RING], axis=1)
FRONT[-1] = FRONT[0]


def cloud(noise=0.05, count=1500, seed=0):
    random = np.random.default_rng(seed + 9)
    return np.column_stack([random.uniform(3, 13, (count, 2)), random.normal(8, noise, count)])


@pytest.fixture(scope="module")
def labels(tmp_path_factory):
    path = tmp_path_factory.mktemp("volume") / "labels.npz"
    grains = np.ones((16, 16, 16), int)
    grains[8:] = 2
    write_labels(path, Voxels(grains, (1, 1, 1), (0, 0, 0)))
    return path


def csv(path, points):
    np.savetxt(path, points, delimiter=",", header="x,y,z", comments="")
    return str(path)


def surface_file(path, points):
    """A fan of triangles from the first point, as the suffix says."""
    triangles = np.array([[0, k, k + 1] for k in range(1, len(points) - 1)])
    if path.suffix == ".vtp":
        rim = np.append(np.arange(len(points)), 0)
        write_crack(path, Crack(points, triangles, (rim,)))
    else:
        write_triangles(path, points, triangles)
    return str(path)


def flags_of(kind, folder, change):
    """Return the flags of a crack of that kind whose file's points went through `change`."""
    if kind in (".stl", ".ply", ".obj", ".off", ".3mf", ".vtp"):
        return ["--shape", "surface", "--file", surface_file(folder / f"c{kind}", change(FRONT[:-1]))]
    if kind == "fronts":
        return ["--shape", "fronts", "--file", csv(folder / "c.csv", change(FRONT))]
    if kind == "front of a surface":
        whole = ["--shape", "surface", "--file", surface_file(folder / "c.obj", FRONT[:-1])]
        return [*whole, "--front", csv(folder / "f.csv", change(FRONT))]
    own = ["--shape", "points", "--file", csv(folder / "p.csv", change(cloud()))]
    return [*own, "--front", csv(folder / "f.csv", FRONT)]


def made(labels, folder, flags, capsys):
    """Return exit status, error and report of `craftmesh crack`."""
    report = folder / "r.json"
    words = ["crack", str(labels), "-o", str(folder / "o.vtp"), "--report", str(report)]
    status = main([*words, *flags, "--l-min", "0.8"])
    return status, capsys.readouterr().err, json.loads(report.read_text()) if status == 0 else {}


KINDS = [".stl", ".ply", ".obj", ".off", ".3mf", ".vtp", "fronts", "front of a surface", "points"]
CHANGES = {
    "as it is": (lambda p: p, None),
    "mm beside um": (lambda p: p * 1e-3, r"about 1000 times as small \(mm beside um\?\)"),
    "um beside mm": (lambda p: p * 1e3, r"about 1000 times as large \(um beside mm\?\)"),
    "mm beside m": (lambda p: p * 1e-6, r"1000000 times as small \(m beside um\?\)|larger than l_min"),
    "outside": (lambda p: p + [40, 0, 0], r"44\.\d|43\.\d+"),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("change", CHANGES)
def test_a_crack_in_another_unit_or_place_is_refused_with_both_extents(
    kind, change, labels, tmp_path, capsys
):
    apply, said = CHANGES[change]
    status, error, report = made(labels, tmp_path, flags_of(kind, tmp_path, apply), capsys)
    if said is None:
        assert status == 0 and "notes" not in report
        return
    assert status == 1 and error.count("\n") == 1 and not (tmp_path / "o.vtp").exists()
    assert "16.0, 16.0, 16.0" in error or kind == "points"
    with pytest.raises(CraftmeshError, match=said):
        raise CraftmeshError(error)


def test_a_plane_far_past_the_box_is_noted(labels, tmp_path, capsys):
    flags = flags_of(".obj", tmp_path, lambda p: (p - 8) * 1e3 + 8)
    status, _, report = made(labels, tmp_path, flags, capsys)
    assert status == 0 and "about 1000 times as large (um beside mm?)" in report["notes"][0]


@pytest.mark.parametrize(("scale", "notes"), [(1.0, 0), (1e3, 1)])
def test_a_path_without_a_point_in_the_crack_is_noted(scale, notes, labels, tmp_path, capsys):
    at = np.arange(12.0)
    np.savetxt(
        tmp_path / "p.csv", np.stack([at, 0.3 * np.sin(at)], 1), delimiter=",", header="x,y", comments=""
    )
    flags = ["--shape", "path", "--file", str(tmp_path / "p.csv"), "--scale", str(scale), "--radius", "6"]
    status, error, report = made(labels, tmp_path, [*flags, "--centre", "0", "8", "8"], capsys)
    assert (status, len(report.get("notes", []))) == (0, notes), error


@pytest.mark.parametrize(
    ("points", "said"),
    [
        (cloud() + [0, 0, 1.5], r"front lies 1\.\d+ under the nearest points of the cloud"),
        (8 + (cloud() - 8) * 0.1, "the cloud has another size"),
        (cloud() + [30, 0, 0], "no point of the cloud is within the front"),
        (
            np.concatenate([cloud(seed=k) + [0, 0, 2 * k] for k in (-1, 0, 1)]),
            "fitted crack is .* .root mean square. and at most",
        ),
    ],
)
def test_clouds_that_their_front_does_not_bound_are_refused(points, said):
    with pytest.raises(CraftmeshError, match=said):
        crack_through_points(points, [FRONT], BOX, None, 0.5)


@pytest.mark.parametrize("noise", [0.0, 0.05, 0.5])
def test_noise_alone_is_no_misfit(noise):
    """The surface is off random points by their own scatter, so however large that is."""
    _, report = crack_through_points(cloud(noise), [FRONT], BOX, None, 0.1)
    assert report["deviation_rms"] < 1.2 * noise + 1e-9


def test_single_points_off_are_noted():
    points = cloud(0.01)
    points[np.argmin(np.linalg.norm(points - 8, axis=1)), 2] += 3
    _, report = crack_through_points(points, [FRONT], BOX, None, 0.5)
    assert "away from its points, which is over 0.5 (l_min" in report["notes"][0]


AT = np.moveaxis(np.indices((32, 32, 32)), 0, -1) + 0.5 - 16
X, Y, Z = np.moveaxis(AT, -1, 0)
DISC = np.hypot(X, Y) < 11
REAL = {
    "plane": (np.abs(Z - 0.5) < 0.1) & DISC,
    "two layers": (np.abs(Z) < 1) & DISC,
    "tilted": (np.abs(Z - 0.6 * X - 0.2 * Y) < 0.7) & DISC,
    "bowl": (np.abs(Z - 0.03 * (X**2 + Y**2)) < 0.9) & DISC,
    "wave": (np.abs(Z - 2 * np.sin(X / 3)) < 0.8) & DISC,
}
NONSENSE = {
    "all": np.ones((12, 12, 12), bool),
    "closed shell": np.abs(np.linalg.norm(AT, axis=-1) - 9) < 0.8,
    "block": (np.abs(AT) < 6).all(axis=-1),
    "two sheets over each other": DISC & (np.abs(np.abs(Z) - 5.5) < 0.1),
}


@pytest.mark.parametrize("name", REAL)
def test_layers_of_voxels_pass(name):
    _, report = crack_through_voxels(REAL[name], np.ones(3), np.zeros(3), 2 * BOX)
    assert report["deviation_rms"] < 1.0 and "notes" not in report


@pytest.mark.parametrize("name", NONSENSE)
def test_voxels_that_are_no_sheet_are_refused(name, edge=0.01):
    with pytest.raises(CraftmeshError, match=r"over .*, 2 voxels; expected a layer of voxels"):
        crack_through_voxels(
            NONSENSE[name], np.full(3, edge), np.zeros(3), len(NONSENSE[name]) / 16 * edge * BOX
        )


def test_a_thick_layer_is_noted():
    thick = (np.abs(Z) < 3) & DISC
    _, report = crack_through_voxels(thick, np.ones(3), np.zeros(3), 2 * BOX)
    assert "which is over 2, 2 voxels" in report["notes"][0]


STRAYS = np.zeros((32, 32, 32), bool)
STRAYS[tuple(np.random.default_rng(3).integers(0, 32, (3, 25)))] = True
SHEET = REAL["two layers"]
AT_FACE = (np.abs(Z) < 1) & (np.hypot(X, Y - 16) < 11)
PINHOLES = np.zeros((32, 32), bool)
PINHOLES[8:26:3, 7:26:3] = True
PINHOLES[[12, 14, 17, 18], 31] = True
SEGMENTED = {
    "stray voxels": (
        SHEET,
        SHEET | (STRAYS & (np.abs(Z) > 4)),
        "left out 17 stray pieces of at most 1 voxels",
    ),
    "pinholes": (
        SHEET,
        SHEET & ~PINHOLES[..., None],
        "filled 36 pinholes, 8.1% of the crack's area, and 0 gaps",
    ),
    "gaps at the mouth": (AT_FACE, AT_FACE & ~PINHOLES[..., None], "area, and 3 gaps at its mouth"),
    "a hole of five": (
        None,
        SHEET & (np.hypot(X, Y) > 2.6),
        "kept 1 holes over 3 wide: their rims are fronts",
    ),
}


@pytest.mark.parametrize("name", SEGMENTED)
def test_noise_of_a_segmentation_is_taken_away_and_told(name):
    """The crack is that without the noise: its fronts are off by less than half a voxel."""
    plain, noisy, said = SEGMENTED[name]
    surface, report = crack_through_voxels(noisy, np.ones(3), np.full(3, -16.0), 2 * BOX - 16)
    assert said in " ".join(report.get("notes", [])), report
    if plain is not None:
        right, report = crack_through_voxels(plain, np.ones(3), np.full(3, -16.0), 2 * BOX - 16)
        assert "notes" not in report
        assert np.abs(span_of(surface.points) - span_of(right.points)).max() < 0.5
        area, wanted = (total_area(one.points, one.triangles) for one in (surface, right))
        assert area == pytest.approx(wanted, rel=0.02)
        assert np.abs(surface.points[:, 2]).max() < 0.5


def test_a_large_second_piece_is_refused():
    two = (np.abs(Z) < 1) & ((np.hypot(X + 8, Y) < 5) | (np.hypot(X - 8, Y) < 2.5))
    with pytest.raises(CraftmeshError, match="forms 2 regions, each over 0.1 times the largest"):
        crack_through_voxels(two, np.ones(3), np.zeros(3), 2 * BOX)


def isosurface(mask):
    """The triangles of marching cubes around voxels, in model units."""
    points, triangles, _, _ = marching_cubes(mask.astype(float), 0.5)
    return points + 0.5 - 16, triangles.astype(np.int64)


def fan(height, count=40):
    """A disc of radius 9 across z."""
    turn = np.linspace(0, 2 * np.pi, count, endpoint=False)
    rim = np.stack([9 * np.cos(turn), 9 * np.sin(turn), height + 0 * turn], axis=1)
    ring = np.arange(1, count + 1)
    return np.vstack([[0, 0, height], rim]), np.stack([0 * ring, ring, np.roll(ring, -1)], axis=1)


def both(one, other):
    return np.vstack([one[0], other[0]]), np.vstack([one[1], other[1] + len(one[0])])


SHELLS = {
    "two layers": isosurface((np.abs(Z) < 1) & DISC),
    "open at the mouth": isosurface((np.abs(Z) < 1) & (np.hypot(X, Y - 16) < 11)),
    "wave": isosurface(REAL["wave"]),
    "tilted": isosurface(REAL["tilted"]),
    "one side on the other": both(fan(0), fan(0)),
}


@pytest.mark.parametrize("name", SHELLS)
def test_a_thin_shell_is_the_sheet_in_its_middle(name):
    surface, report = middle_sheet(*SHELLS[name], 2 * BOX - 16)
    assert "the surface is a thin shell" in report["notes"][0]
    height = {"wave": 2 * np.sin(surface.points[:, 0] / 3)}.get(name, 0)
    if name == "tilted":
        height = surface.points @ [0.6, 0.2, 0]
    # measured 0.6 at the rim of the wave, whose voxels are steps of 1
    assert np.abs(surface.points[:, 2] - height).max() < (0.7 if name in REAL else 0.05)
    crack = crack_from_triangles(surface.points, surface.triangles, None, 2 * BOX - 16)
    assert len(crack.fronts) == 1
    line = crack.points[crack.fronts[0]]
    radius = np.hypot(line[:, 0], line[:, 1] - (16 if "mouth" in name else 0))
    # voxels end half a voxel about the circle, discs of edges of their own exactly
    assert np.abs(radius - (9 if "side" in name else 11)).max() < 0.6
    with pytest.raises(CraftmeshError, match="thin shell|not a manifold|folded"):
        crack_from_triangles(*SHELLS[name], None, 2 * BOX - 16)


OTHERS = {
    "ball": isosurface(np.linalg.norm(AT, axis=-1) < 8),
    "cube": isosurface((np.abs(AT) < 6).all(axis=-1)),
    "sheet": fan(0),
    "bowl": (fan(0)[0] + 0.03 * fan(0)[0][:, :1] ** 2 * [[0, 0, 1]], fan(0)[1]),
    "two sheets": both(fan(-0.3), fan(0.3)),
    "folded by 170 degrees": (
        np.array([[0, 0, 0], [0, 9, 0], [9, 0, 0.8], [9, 9, 0.8], [9, 0, -0.8], [9, 9, -0.8]]),
        np.array([[0, 2, 1], [2, 3, 1], [0, 1, 4], [4, 1, 5]]),
    ),
    "oblate": isosurface(X**2 + Y**2 + (2.5 * Z) ** 2 < 10**2),
}


@pytest.mark.parametrize("name", OTHERS)
def test_other_surfaces_are_no_thin_shells(name):
    assert sides_apart(*OTHERS[name], 2 * BOX - 16) is None
    surface, report = middle_sheet(*OTHERS[name], 2 * BOX - 16)
    assert surface.triangles is OTHERS[name][1] and not report


def test_a_shell_that_is_no_height_is_refused():
    bowl = isosurface((np.abs(np.linalg.norm(AT, axis=-1) - 12) < 1) & (Z < 8))
    with pytest.raises(CraftmeshError, match="a thin shell, but not single-valued over"):
        middle_sheet(*bowl, 2 * BOX - 16)


@pytest.mark.parametrize("power", range(-9, 10))
def test_units_are_named_where_a_power_of_ten_parts_them(power):
    hint = unit_hint(span_of(FRONT * 10.0**power), span_of(FRONT))
    assert (str(10 ** abs(power)) in hint) == (power != 0) and ("?" in hint) == (
        abs(power) in (1, 2, 3, 6, 9)
    )
    assert unit_hint(span_of(FRONT + 50), span_of(FRONT)) == ""


@pytest.mark.parametrize(
    "size, is_right", [(0.29, False), (0.31, True), (1.0, True), (29.0, True), (31.0, False)]
)
def test_a_cloud_from_three_tenths_to_thirty_times_as_wide_as_its_front_is_taken(size, is_right):
    front = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [-1, -1, 0]])
    if is_right:
        refuse_other_place(size * front, [front])
    else:
        with pytest.raises(CraftmeshError, match="the cloud has another size: the cloud goes from"):
            refuse_other_place(size * front, [front])


@pytest.mark.parametrize("off, is_right", [(2.49, True), (2.51, False)])
def test_a_cloud_may_lie_beside_its_front_by_a_quarter_of_its_diagonal(off, is_right):
    front = np.array([[0.0, 0, 0], [8, 0, 0], [8, 6, 0], [0, 6, 0], [0, 0, 0]])
    cloud = front + [8 + off, 0, 0]
    if is_right:
        refuse_other_place(cloud, [front])
    else:
        with pytest.raises(CraftmeshError, match="no point of the cloud is within the front"):
            refuse_other_place(cloud, [front])


@pytest.mark.parametrize("size, notes", [(1.01, 0), (29.0, 0), (31.0, 1)])
def test_a_crack_is_longer_than_l_min_and_noted_from_thirty_boxes_on(size, notes):
    crack, box = np.array([[0.0, 0, 0], [0.6, 0.8, 0]]), np.array([[0.0, 0, 0], [1, 0, 0]])
    assert len(notes_on_size(size * crack, box, 1.0)) == notes
    with pytest.raises(CraftmeshError, match="must be larger than l_min"):
        notes_on_size(0.99 * crack, box, 1.0)

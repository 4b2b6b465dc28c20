"""Cracks in other units or places than the volume, and fits that are off what they are fitted to."""

import json

import numpy as np
import pytest
from surface_writer import write_triangles

from craftmesh.cli import main
from craftmesh.cracks.measured import crack_through_points
from craftmesh.cracks.voxel_crack import crack_through_voxels
from craftmesh.errors import CraftmeshError
from craftmesh.io.npz import write_labels
from craftmesh.io.vtk import write_crack
from craftmesh.surface.measure import span_of
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
        (cloud() + [0, 0, 1.5], r"front lies 1\.\d+ under the point cloud beside it"),
        (8 + (cloud() - 8) * 0.1, "the cloud is of another size"),
        (cloud() + [30, 0, 0], "no point of the cloud is within the front"),
        (
            np.concatenate([cloud(seed=k) + [0, 0, 2 * k] for k in (-1, 0, 1)]),
            "off its points by .* in the root",
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
    assert "at most, which is over 0.5 (l_min" in report["notes"][0]


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
    with pytest.raises(CraftmeshError, match=r"off its points by .*, 2 voxels; expected a layer of voxels"):
        crack_through_voxels(
            NONSENSE[name], np.full(3, edge), np.zeros(3), len(NONSENSE[name]) / 16 * edge * BOX
        )


def test_a_thick_layer_is_noted():
    thick = (np.abs(Z) < 3) & DISC
    _, report = crack_through_voxels(thick, np.ones(3), np.zeros(3), 2 * BOX)
    assert "which is over 2, 2 voxels" in report["notes"][0]


@pytest.mark.parametrize("power", range(-9, 10))
def test_units_are_named_where_a_power_of_ten_parts_them(power):
    hint = unit_hint(span_of(FRONT * 10.0**power), span_of(FRONT))
    assert (str(10 ** abs(power)) in hint) == (power != 0) and ("?" in hint) == (
        abs(power) in (1, 2, 3, 6, 9)
    )
    assert unit_hint(span_of(FRONT + 50), span_of(FRONT)) == ""

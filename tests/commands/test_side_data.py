"""Data beside the volume: each kind in another unit or place, for a part of it, or of other grains."""

import json

import numpy as np
import pytest
import tifffile
import vtk_objects
from warped_cracks import disc_crack

from craftmesh.cli import main
from craftmesh.errors import CraftmeshError
from craftmesh.io.npz import write_labels
from craftmesh.io.vtk import read_crack, write_surface
from craftmesh.mechanics.eigenstrains import as_strain
from craftmesh.mechanics.lips import LipField
from craftmesh.mechanics.model import elastic_model
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.remeshing.remesh import RemeshOptions, remesh
from craftmesh.types import Voxels

SHAPE, EDGE = (20, 16, 12), 0.5
BOX = "from [0.0, 0.0, 0.0] to [10.0, 8.0, 6.0]"
SIZES = "--l-min .4 --l0 .5 --l-max 1.5 --r0 1 --r1 2"
FITS = ""


@pytest.fixture(scope="module")
def body(tmp_path_factory):
    """A folder with the labels and the surface of two grains in a box of 10 by 8 by 6."""
    folder = tmp_path_factory.mktemp("body")
    labels = np.ones(SHAPE, np.int32)
    labels[10:] = 2
    voxels = Voxels(labels, [EDGE] * 3, (0.0, 0.0, 0.0))
    write_labels(folder / "labels.npz", voxels)
    write_surface(folder / "surface.vtp", remesh(voxels, RemeshOptions())[0])
    return folder


@pytest.fixture
def call(body, tmp_path, monkeypatch, capsys):
    """Return a function that runs a verb in a new folder: status, error and notes."""
    monkeypatch.chdir(tmp_path)

    def run(line):
        status = main([*line.format(body=body).split(), "--report", "r.json"])
        notes = json.loads((tmp_path / "r.json").read_text()).get("notes", []) if status == 0 else []
        return status, capsys.readouterr().err, notes

    return run


def judged(outcome, wanted):
    """Check status, error and notes against words: FITS, "note: ..." or those of an error in one line."""
    status, error, notes = outcome
    if wanted.startswith("note: ") or wanted == FITS:
        assert status == 0 and wanted.removeprefix("note: ") in " ".join(notes), (error, notes)
        assert bool(notes) == bool(wanted)
    else:
        assert status == 1 and error.count("\n") == 1 and wanted in error, (error, notes)


def marks(shape=SHAPE):
    """A disc of marked voxels across z in the middle of a volume."""
    x, y, z = np.indices(shape)
    middle = np.array(shape) // 2
    return (((x - middle[0]) ** 2 + (y - middle[1]) ** 2 < 20) & (z == middle[2])).astype(np.uint8)


def mha(path, labels, spacing, origin):
    """Write a MetaImage; its offset is the centre of the first voxel."""
    head = f"ObjectType = Image\nNDims = 3\nDimSize = {' '.join(map(str, labels.shape))}\n"
    head += f"ElementSpacing = {' '.join(map(str, spacing))}\n"
    head += f"Offset = {' '.join(str(o + d / 2 if o else 0) for o, d in zip(origin, spacing))}\n"
    head += "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n"
    path.write_bytes(head.encode() + labels.tobytes(order="F"))


def vti(path, labels, spacing, origin):
    from vtkmodules.vtkCommonDataModel import vtkImageData

    image = vtkImageData()
    image.SetDimensions(*(n + 1 for n in labels.shape))
    image.SetSpacing(*spacing)
    image.SetOrigin(*origin)
    vtk_objects.add_arrays(image.GetCellData(), {"material": labels.ravel(order="F").astype(np.int32)})
    vtk_objects.write_dataset(path, image, "ImageData")


BARE = {
    "npz": lambda path, labels: np.savez(path, labels=labels),
    "npy": lambda path, labels: np.save(path, labels),
    "tif": lambda path, labels: tifffile.imwrite(path, labels.T),
    "mha": lambda path, labels: mha(path, labels, (1, 1, 1), (0, 0, 0)),
    "vti": lambda path, labels: vti(path, labels, (1, 1, 1), (0, 0, 0)),
}
PLACED = {
    "npz": lambda path, labels, spacing, origin: np.savez(
        path, labels=labels, spacing=spacing, origin=origin
    ),
    "mha": mha,
    "vti": vti,
}
CRACK = "crack {body}/labels.npz --shape voxels --file m.%s --l-min .4 -o c.vtp"


@pytest.mark.parametrize("kind", BARE)
@pytest.mark.parametrize(
    ("shape", "wanted"),
    [
        (SHAPE, "placed on the microstructure's"),
        (SHAPE[::-1], "exchange the file's axes"),
        ((20, 16, 13), "no spacing"),
    ],
)
def test_a_mask_without_spacing_has_the_grid_of_the_volume(kind, shape, wanted, call, tmp_path):
    BARE[kind](tmp_path / f"m.{kind}", marks(shape))
    outcome = call(CRACK % kind)
    if shape == SHAPE:
        wanted = FITS if kind in ("npy", "tif") else f"note: {wanted}"
        crack = read_crack("c.vtp").points
        # the disc's voxels end 4.5 voxels round the middle of voxel (10, 8, 6)
        assert np.abs(crack.mean(axis=0) - [5.25, 4.25, 3.25]).max() < 0.05
        assert np.abs(np.ptp(crack[:, :2], axis=0) - 4.5).max() < 0.3
    judged(outcome, wanted)


@pytest.mark.parametrize("kind", PLACED)
@pytest.mark.parametrize(
    ("shape", "spacing", "origin", "wanted"),
    [
        (SHAPE, EDGE, 0.0, FITS),
        (SHAPE, EDGE * 1e-3, 0.0, "about 1000 times as small (mm beside um?)"),
        (SHAPE, EDGE * 1e3, 0.0, "about 1000 times as large (um beside mm?)"),
        (SHAPE, 0.75, 2.0, f"of another size: the voxels go from [2.0, 2.0, 2.0] to [17.0, 14.0, 11.0], "
         f"the microstructure {BOX}"),
        (SHAPE, EDGE, 40.0, "61 of 61 marked voxels lie outside; give"),
        (SHAPE, EDGE, 2.0, "note: the file's voxels form another grid"),
        ((40, 32, 24), EDGE / 2, 0.0, "note: the file's voxels form another grid"),
        (SHAPE[::-1], EDGE, 0.0, "exchange the file's axes"),
    ],
)  # fmt: skip
def test_a_mask_with_a_grid_of_its_own_has_to_fit(kind, shape, spacing, origin, wanted, call, tmp_path):
    PLACED[kind](tmp_path / f"m.{kind}", marks(shape), [spacing] * 3, [origin] * 3)
    judged(call(CRACK % kind), wanted)


def csv(path, points, header="x,y,z"):
    np.savetxt(path, points, delimiter=",", header=header, comments="")


CLOUD = np.array([[2.0, 3, 4], [5, 6, 2], [8, 1, 5]])
POINTS = [
    (CLOUD, FITS),
    (CLOUD * 1e-3, "about 1000 times as small (mm beside um?)"),
    (CLOUD * 1e3, "about 1000 times as large (um beside mm?)"),
    (CLOUD[:1] * 1e-3, "note: p.csv: the points go from [0.002, 0.003, 0.004]"),
    (CLOUD + 400, f"3 of 3 points lie outside the body; the points go from [402.0, 401.0, 402.0] to "
     f"[408.0, 406.0, 405.0], the body {BOX}"),
    (CLOUD + [7, 0, 0], "note: p.csv: 2 of 3 points lie outside the body"),
    (CLOUD / 10, FITS),
]  # fmt: skip


@pytest.mark.parametrize("flag", ["--points", "--front"])
@pytest.mark.parametrize(("points", "wanted"), POINTS)
def test_points_to_refine_around_lie_in_the_body(flag, points, wanted, call, tmp_path):
    csv(tmp_path / "p.csv", points)
    judged(call(f"size {{body}}/surface.vtp {flag} p.csv {SIZES} -o s.npz"), wanted)


@pytest.mark.parametrize(
    ("header", "rows", "wanted"),
    [
        ("EqDiameter,BaryCenterX,BaryCenterY,BaryCenterZ", [[1, 2, 3, 4]], FITS),
        ("EqDiameter,BaryCenterX,BaryCenterY,BaryCenterZ", [[1, 2e3, 3e3, 4e3]], "(um beside mm?)"),
        (
            "EqDiameter,BaryCenterX,BaryCenterY,BaryCenterZ",
            [[1e-3, 2e-3, 3e-3, 4e-3], [1e-3, 8e-3, 2e-3, 1e-3]],
            "about 1000 times as small (mm beside um?)",
        ),
        (
            "EqDiameter,BaryCenterX,BaryCenterY,BaryCenterZ",
            [[1, 2, 3, 4], [1, 20, 3, 4]],
            "note: p.csv: 1 of 2 points lie outside the body",
        ),
        ("id,x,y,z,r", [[0, 0.5, 0.5, 0.5, 0.1]], FITS),
        ("id,x,y,z,r", [[0, 4, 5, 3, 1]], "are fractions of the box"),
    ],
)
def test_pores_to_refine_around_lie_in_the_body(header, rows, wanted, call, tmp_path):
    csv(tmp_path / "p.csv", rows, header)
    judged(call(f"size {{body}}/surface.vtp --points p.csv {SIZES} -o s.npz"), wanted)


@pytest.mark.parametrize(
    ("spacing", "origin", "wanted"),
    [
        (1.0, 0.0, FITS),
        (1.0, -1.0, "note: f.vti: covers"),
        (1e-3, 0.0, "note: (mm beside um?)"),
        (1.0, 400.0, "covers 0.00% of the surface's points"),
    ],
)
def test_a_field_of_lengths_covers_the_body(spacing, origin, wanted, call, tmp_path):
    lengths = np.full((11, 9, 7) if origin == 0 else (6, 9, 7), 1.0)
    from vtkmodules.vtkCommonDataModel import vtkImageData

    image = vtkImageData()
    image.SetDimensions(*lengths.shape)
    image.SetSpacing(*[spacing] * 3)
    image.SetOrigin(*[origin] * 3)
    vtk_objects.add_arrays(image.GetPointData(), {"h": lengths.ravel(order="F")})
    vtk_objects.write_dataset(tmp_path / "f.vti", image, "ImageData")
    judged(call(f"size {{body}}/surface.vtp --field f.vti --field-array h {SIZES} -o s.npz"), wanted)


@pytest.fixture(scope="module")
def cracked():
    return disc_crack(3, 3, 3)  # of radius 1 in the middle of a box


def told_of(mesh, **known):
    """Return what a model of the mesh is refused for, or its notes."""
    options = {"lip_field": "f.csv"} if "lip_field" in known else {"eigenstrain_file": "e.csv"}
    options = ModelOptions(material=("isotropic:1e3,0.3",), load="none", **options)
    try:
        return " ".join(
            f"note: {note}" for note in elastic_model(mesh, options, **known)[1].get("notes", [])
        )
    except CraftmeshError as error:
        return str(error)


RINGS, TURNS = (part.ravel() for part in np.meshgrid(np.linspace(0, 1, 11), np.linspace(0, 2 * np.pi, 40)))
DISC = np.column_stack([RINGS * np.cos(TURNS), RINGS * np.sin(TURNS), 0 * TURNS])


@pytest.mark.parametrize(
    ("points", "wanted"),
    [
        (DISC, FITS),
        (DISC[:1], FITS),
        (DISC * 1.5, FITS),
        (np.array([[x, y, 0.0] for x in (-2, 0, 2) for y in (-2, 0, 2)]), FITS),
        (DISC * 1e-3, "about 1000 times as small (mm beside um?)"),
        (DISC + [0.0, 0, 50], "440 of 440 points lie outside the body; the points go from"),
        (DISC[:1] + 50, "1 of 1 points lie outside the body"),
        (DISC[DISC[:, 0] > 0], "% of the lips, the farthest place is"),
        (DISC[RINGS > 0.95], "% of the lips, the farthest place is"),
        (DISC + [0, 0, 0.8], "cover 0.0% of the lips, the farthest place is 0.8"),
    ],
)
def test_a_field_covers_the_lips(cracked, points, wanted):
    field = LipField(points, np.ones(len(points)), np.zeros((len(points), 3)))
    found = told_of(cracked, lip_field=field)
    assert (wanted in found) if wanted else not found


@pytest.mark.parametrize(
    ("ids", "wanted"),
    [
        ([1], FITS),
        ([1, 7, 9], "note: eigenstrain_file: ignored the ids 7, 9, which no grain of the mesh has"),
        ([0, 2], "no row for 1 of 1 grains: 1; the table has 0, 2; give one row per grain"),
    ],
)
def test_a_table_of_grains_has_a_row_for_each(cracked, ids, wanted):
    assert set(cracked.grain.tolist()) == {1}
    found = told_of(cracked, grain_strains={grain: as_strain(np.array([1e-3])) for grain in ids})
    assert (wanted in found) if wanted else not found

"""FIFOs and devices under the names of files: every door refuses them at once, one row a door and kind."""

import os

import numpy as np
import pytest

from craftmesh.campaign import craftmesher
from craftmesh.campaign.cases import check_exists
from craftmesh.campaign.workflow_location import read_config
from craftmesh.cli import main
from craftmesh.deck.check_deck import check_deck
from craftmesh.errors import CraftmeshError
from craftmesh.io import hdf5, json_file, model_tables, npz, point_files, stage_npz, user_material, vtk
from craftmesh.io.front_csv import read_front, read_fronts
from craftmesh.io.mesh_formats import read_exodus
from craftmesh.io.point_fields import read_stress_field, read_temperature
from craftmesh.io.surface_files import read_grain_folder, read_triangles
from craftmesh.io.text_table import read_rows
from craftmesh.voxels.reading import ReadOptions, read_marked, read_voxels

MARK = "not a regular file"


def hdf5_file(path):
    with hdf5.opened(path):
        pass


def config_of(path):
    check_exists("crack.file", path)


VOLUMES = (".npz", ".npy", ".dream3d", ".h5", ".vti", ".tif", ".tesr", ".mha", ".mhd", ".nrrd", ".nhdr")
VOLUMES += (".mat", ".vtk", ".vtr", ".json", ".raw")
DOORS = [
    *[(suffix, read_voxels) for suffix in VOLUMES],
    *[(suffix, lambda path: read_marked(path, None)) for suffix in (".npz", ".tif", ".vti")],
    (".x", lambda path: read_voxels(path, ReadOptions(format="labdct"))),
    (".h5", hdf5_file),
    (".npz", npz.load),
    (".npz", npz.read_labels),
    (".npz", stage_npz.read_grain_tets),
    (".npz", stage_npz.read_sizing),
    (".npz", stage_npz.read_solutions),
    (".json", json_file.read_json),
    (".csv", read_rows),
    (".csv", read_front),
    (".csv", read_fronts),
    (".csv", point_files.read_points),
    (".xyz", point_files.read_points),
    (".vtp", point_files.read_points),
    (".ply", point_files.read_points),
    (".csv", model_tables.read_displacement_table),
    (".npz", model_tables.read_displacement_table),
    (".frd", model_tables.read_displacements),
    (".csv", model_tables.read_grain_strains),
    (".csv", model_tables.read_lip_field),
    (".csv", model_tables.read_slip_table),
    *[(suffix, read) for suffix in (".csv", ".vtu") for read in (read_stress_field, read_temperature)],
    *[(suffix, read_triangles) for suffix in (".stl", ".ply", ".obj", ".3mf")],
    ("_1.stl", lambda path: read_grain_folder(path.parent)),
    *[(".vtp", read) for read in (vtk.read_surface, vtk.read_crack)],
    (".vtu", vtk.read_tets),
    (".e", read_exodus),
    (".yaml", lambda path: user_material.read_template(str(path))),
    (".yaml", read_config),
    (".xml", craftmesher.read_config),
    (".stl", config_of),
    (".inp", check_deck),
]


@pytest.fixture(params=["FIFO", "device"])
def put(request):
    def irregular(path):
        if request.param == "FIFO":
            os.mkfifo(path)
        else:
            path.symlink_to("/dev/zero")
        return path

    return irregular


@pytest.mark.timeout(20)  # a door that opens the FIFO waits for ever
@pytest.mark.parametrize("suffix, read", DOORS, ids=lambda v: getattr(v, "__name__", v))
def test_every_door_refuses_what_is_no_regular_file(tmp_path, put, suffix, read):
    path = put(tmp_path / f"v{suffix}")
    with pytest.raises(CraftmeshError) as caught:
        read(path)
    assert MARK in str(caught.value) and str(path) in str(caught.value)


@pytest.mark.timeout(20)
@pytest.mark.parametrize("name", ["s_2.tif", "s_1.tif"])
def test_slices_and_data_files(tmp_path, put, name):
    (tmp_path / "s_3.tif").write_bytes(b"")
    put(tmp_path / name)
    with pytest.raises(CraftmeshError, match="FIFO or device"):
        read_voxels(tmp_path)
    put(tmp_path / "v.raw")
    head = "NDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = v.raw\n"
    (tmp_path / "v.mhd").write_text(head)
    with pytest.raises(CraftmeshError, match=MARK):
        read_voxels(tmp_path / "v.mhd")


VERBS = [
    "init v.npz",
    "import v.npz --labels l.npz",
    "import-config v.xml -o c.yaml",
    "remesh v.npz -o s.vtp",
    "stitch v.vtp -o s.vtp",
    "crack labels.npz -o c.vtp --shape surface --file v.stl",
    "plan v.yaml",
    "run v.yaml",
    "view v.vtp",
    "check v.vtu",
    "generate --voids-from v.csv -o l.npz",
]


@pytest.mark.timeout(60)
@pytest.mark.parametrize("words", VERBS, ids=lambda words: words.split()[0])
def test_verbs_refuse_them_in_one_line(tmp_path, monkeypatch, capsys, put, words):
    monkeypatch.chdir(tmp_path)
    np.savez("labels.npz", labels=np.ones((2, 2, 2), np.int32), spacing=np.ones(3), origin=np.zeros(3))
    put(tmp_path / next(word for word in words.split() if word.startswith("v.")))
    with pytest.raises(SystemExit) as ended:
        raise SystemExit(main(words.split()))
    line = capsys.readouterr().err.strip()
    assert ended.value.code == 1 and MARK in line.splitlines()[-1], line

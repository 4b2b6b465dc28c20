"""What `craftmesh init` writes is a campaign that is accepted, fits the microstructure, and runs."""

import numpy as np
import pytest
import yaml

from craftmesh.campaign.campaign import read_campaign
from craftmesh.cli import main
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.series import prescribed_crack
from craftmesh.io.npz import write_labels
from craftmesh.mechanics.crystals import METALS
from craftmesh.types import Crystal, Voxels
from craftmesh.voxels.generate import GenerateOptions, generate


def volume(folder, name="scan 1.npz", scale=1.0, **others):
    voxels = generate(
        GenerateOptions(shape=(16, 15, 14), grains=5, voids=0, embedded_grains=0, embedded_pairs=0)
    )
    spacing = np.array([1.0, 1.0, 1.25]) * scale
    arrays = {"labels": voxels.labels, "spacing": spacing, "origin": [5.0, 6, 7]} | others
    np.savez(folder / name, **arrays)
    return folder / name


def init(folder, monkeypatch, *words) -> dict:
    monkeypatch.chdir(folder)
    assert main(["init", *map(str, words)]) == 0
    (path,) = folder.glob("*.yaml")
    return yaml.safe_load(path.read_text())


@pytest.mark.parametrize("scale", [1.0, 2.5e-3, 1e-6, 1e9])
def test_sizes_and_crack_fit_the_microstructure(tmp_path, monkeypatch, scale):
    config = init(tmp_path, monkeypatch, volume(tmp_path, scale=scale, origin=np.zeros(3)))
    campaign = read_campaign(config)
    assert [case.name for case in campaign.cases.values()] == ["scan_1"]
    sizing = config["sizing"]
    assert 0 < sizing["l_min"] < sizing["l0"] <= sizing["l_max"] <= 3 * sizing["l0"]
    assert sizing["l0"] == pytest.approx(1.25 ** (1 / 3) * scale, rel=1e-3)  # written in four digits
    box = np.array([[0, 0, 0], [16 * scale, 15 * scale, 14 * 1.25 * scale]])
    (options,) = campaign.crack_options("scan_1", "000")
    crack = prescribed_crack(box, CrackOptions(**options))
    (front,) = crack.fronts
    assert (np.abs(crack.points[front][[0, -1], 1]) < 1e-9 * scale).all()  # it begins and ends on the face
    inner = crack.points[front][1:-1]
    assert (inner > box[0]).all() and (inner < box[1]).all()


def test_flags_of_the_reader_go_into_the_configuration(tmp_path, monkeypatch):
    labels = generate(GenerateOptions(shape=(16, 15, 14), grains=5)).labels
    np.save(tmp_path / "v.npy", labels.transpose(2, 1, 0))
    config = init(tmp_path, monkeypatch, "v.npy", "--axes", "zyx", "--spacing", "2", "2", "2")
    assert config["import"]["axes"] == "zyx" and config["import"]["spacing"] == [2, 2, 2]
    assert config["inp"]["material"][0].startswith("isotropic")
    read_campaign(config)


def test_unindexed_voxels_and_specks_are_cleaned_away(tmp_path, monkeypatch, capsys):
    noisy = generate(GenerateOptions(shape=(20, 20, 20), grains=4, shuffled=0.3)).labels.copy()
    noisy[3:5, 3:5, 3:5] = 0
    noisy[10, 10, 10] = 77
    config = init(tmp_path, monkeypatch, volume(tmp_path, labels=noisy))
    assert config["import"]["fill_unindexed"] and config["import"]["smoothing_rounds"] == 2
    assert config["import"]["min_island_voxels"] == 27
    assert "completely absorbed: grain 77 (1 voxels, to grain" in capsys.readouterr().out


def test_each_phase_has_a_material(tmp_path, monkeypatch):
    quaternions = np.tile([1.0, 0, 0, 0], (6, 1))
    path = volume(tmp_path, orientations=quaternions, phases=np.array([0, 1, 1, 2, 2, 2]))
    materials = init(tmp_path, monkeypatch, path)["inp"]["material"]
    assert [text.split(":")[0] for text in materials] == ["1=cubic", "2=cubic"]


def test_stand_ins_are_said_and_known_metals_are_none(tmp_path, monkeypatch, capsys):
    quaternions = np.tile([1.0, 0, 0, 0], (6, 1))
    made = generate(GenerateOptions(shape=(16, 15, 14), grains=5, voids=0, embedded_grains=0))
    crystals = {1: Crystal("cubic", "Aluminum"), 2: Crystal("hexagonal")}
    phases = np.array([0, 1, 1, 2, 2, 2])
    path = tmp_path / "scan_1.npz"
    grid = (np.minimum(made.labels, 5), made.spacing, made.origin)
    write_labels(path, Voxels(*grid, quaternions, phases, crystals))
    config = init(tmp_path, monkeypatch, path)
    assert config["inp"]["material"] == [f"1={METALS['aluminium']}", f"2={METALS['titanium']}"]
    assert config["units"] == {"stress": "MPa"}
    notes = [line for line in capsys.readouterr().out.splitlines() if "placeholder" in line]
    assert len(notes) == 1 and "titanium" in notes[0] and "phase 2 (hexagonal)" in notes[0]
    assert "placeholder for phase 2" in (tmp_path / "scan_1.yaml").read_text()
    read_campaign(config)


def test_nothing_is_overwritten(tmp_path, monkeypatch, capsys):
    path = volume(tmp_path)
    init(tmp_path, monkeypatch, path)
    (tmp_path / "scan_1.yaml").write_text("mine")
    assert main(["init", str(path)]) == 1
    assert "scan_1.yaml: exists already" in capsys.readouterr().err
    (tmp_path / "scan_1.yaml").unlink()
    assert main(["init", str(path)]) == 1
    assert "scan_1.tsv: exists already" in capsys.readouterr().err
    assert not (tmp_path / "scan_1.yaml").exists()


def test_much_without_a_grain_is_the_space_round_a_sample(tmp_path, monkeypatch, capsys):
    grains = generate(GenerateOptions(shape=(16, 15, 14), grains=5, voids=0)).labels
    config = init(tmp_path, monkeypatch, volume(tmp_path, labels=np.pad(grains, 4), origin=np.zeros(3)))
    assert config["import"]["background"] == "void" and "fill_unindexed" not in config["import"]
    assert "taken as empty space" in capsys.readouterr().out
    assert config["cracks"]["notch"]["centre"][1] == 4  # on the sample's face, not on the volume's
    assert config["cracks"]["notch"]["radius"] == pytest.approx(15 / 4)  # half of it is ahead, half beside
    assert config["inp"]["load"] == "none" and config["inp"]["lip_pressure"] > 0  # no face to pull at


def test_what_zero_is_taken_for_is_written_and_said(tmp_path, monkeypatch, capsys):
    labels = generate(GenerateOptions(shape=(16, 15, 14), grains=5, voids=0)).labels
    scattered = np.where(np.random.default_rng(2).random(labels.shape) < 0.08, 0, labels)
    for role, values in (("grain", labels - 1), ("unindexed", scattered), ("void", np.pad(labels, 4))):
        folder = tmp_path / role
        folder.mkdir()
        config = init(folder, monkeypatch, volume(folder, labels=values))["import"]
        assert config["background"] == role and config.get("fill_unindexed", False) == (role == "unindexed")
        assert "background: " in (folder / "scan_1.yaml").read_text().split("# meaning of label 0")[0][-30:]
        assert f"label 0, {(values == 0).sum()} voxels" in capsys.readouterr().out


@pytest.mark.parametrize("labels", ["precipitates", "checkerboard"])
def test_grains_in_many_small_pieces_stay(tmp_path, monkeypatch, capsys, labels):
    shape = (18, 18, 18)
    made = np.ones(shape, int)
    if labels == "precipitates":
        made[1::3, 1::3, 1::3] = 2
    else:
        made = 1 + np.indices(shape).sum(axis=0) % 2
    config = init(tmp_path, monkeypatch, volume(tmp_path, labels=made))
    assert not {"min_island_voxels", "smoothing_rounds"} & config.get("import", {}).keys()
    said = capsys.readouterr().out
    assert "grains: 2" in said and "min_island_voxels and smoothing_rounds stay 0" in said
    (tmp_path / "scan_1.yaml").unlink()
    assert main(["import", "scan 1.npz", "--labels", "l.npz", "--report", "r.json"]) == 0
    np.testing.assert_array_equal(np.load("l.npz")["labels"], made)


def test_import_says_changes_and_notes_line_by_line(tmp_path, monkeypatch, capsys):
    noisy = generate(GenerateOptions(shape=(16, 15, 14), grains=5, voids=0)).labels.copy()
    noisy[3, 3, 3], noisy[8, 8, 8] = 0, 77
    path = volume(tmp_path, labels=noisy)
    flags = ["--fill-unindexed", "--min-island-voxels", "3", "--labels", str(tmp_path / "l.npz")]
    assert main(["import", str(path), *flags]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert sum(line.startswith("change: ") for line in lines) == 2
    assert any(
        line.startswith("note: label 0, 1 voxels (0.03 %), is taken as not indexed") for line in lines
    )


@pytest.mark.parametrize("name", ["x.tsv", "x.json", "x", "x.yaml.txt"])
def test_configuration_and_sheet_are_two_files(tmp_path, monkeypatch, capsys, name):
    monkeypatch.chdir(tmp_path)
    assert main(["init", str(volume(tmp_path)), "-o", name]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert f"--output is {name}; expected a configuration .yaml" in line
    assert [path.name for path in tmp_path.iterdir()] == ["scan 1.npz"]


def write_features(path, labels):
    """Write labels as a .vti whose cell array FeatureIds has 0 for what is not indexed."""
    extent, ids = (" ".join(map(str, some)) for some in (np.kron(labels.shape, [0, 1]), labels.ravel("F")))
    path.write_text(
        '<VTKFile type="ImageData" version="0.1" byte_order="LittleEndian">'
        f'<ImageData WholeExtent="{extent}"><Piece Extent="{extent}"><CellData>'
        f'<DataArray type="Int32" Name="FeatureIds" format="ascii">{ids}</DataArray>'
        "</CellData></Piece></ImageData></VTKFile>"
    )
    return path


@pytest.mark.parametrize("marks", [False, True])
def test_a_notch_is_asked_for_and_the_crack_begins_at_its_root(tmp_path, monkeypatch, capsys, marks):
    monkeypatch.chdir(tmp_path)
    labels = generate(GenerateOptions(shape=(20, 18, 16), grains=12, voids=0)).labels.copy()
    labels[:7, 8:10] = 0
    path = volume(tmp_path, labels=labels, spacing=np.ones(3), origin=np.zeros(3))
    path = write_features(tmp_path / "scan_1.vti", labels) if marks else path
    assert main(["init", str(path)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert f"{path}: label 0, 224 voxels" in line and "--background void" in line
    assert not list(tmp_path.glob("*.yaml"))
    config = init(tmp_path, monkeypatch, path, "--background", "void")
    assert config["import"]["background"] == "void" and "fill_unindexed" not in config["import"]
    crack = config["cracks"]["notch"]
    assert crack["centre"] == [7, 9.2, 8.2] and crack["normal"] == [0, 1, 0] and crack["radius"] == 4
    assert config["inp"]["axis"] == "y"
    assert "at the root of a notch 7 deep in the face x = min" in (tmp_path / "scan_1.yaml").read_text()
    read_campaign(config)


def test_lengths_in_metres_are_numbers(tmp_path, monkeypatch):
    config = init(tmp_path, monkeypatch, volume(tmp_path, spacing=np.full(3, 1e-6), origin=np.zeros(3)))
    assert config["sizing"]["l0"] == 1e-6  # 1e-06 without a point is text to YAML 1.1
    read_campaign(config)

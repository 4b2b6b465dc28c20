"""Every stage file has a picture: a .png of some extent and colours, the same bytes each time."""

import io

import nrrd
import numpy as np
import pytest
from matplotlib.image import imread

from craftmesh.cli import main

FLAGS = "--l-min 0.8 --l0 1 --l-max 2.5 --r0 3 --r1 6"


def run(*words):
    assert main([str(word) for text in words for word in str(text).split()]) == 0


@pytest.fixture(scope="module")
def stages(tmp_path_factory):
    """Return a folder with the files of every stage of a small cracked volume."""
    folder = tmp_path_factory.mktemp("stages")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        run("generate --shape 12 11 10 --grains 4 --voids 0 --embedded-pairs 0 -o made.npz")
        run("import made.npz --labels labels.npz --image volume.vti --islands islands.json")
        run("remesh labels.npz -o remeshed.vtp")
        run("crack labels.npz --centre 6 0 5.2 --radius 4 -o crack.vtp")
        run(f"size remeshed.vtp --crack crack.vtp {FLAGS} -o sizing.npz")
        run("stitch remeshed.vtp --crack crack.vtp --sizing sizing.npz -o surface.vtp")
        run("gradate surface.vtp --sizing sizing.npz -o gradated.vtp")
        run("tetrahedralize gradated.vtp --sizing sizing.npz --workers 1 -o volume.vtu")
        (folder / "front.csv").write_text("x,y,z\n2,0,5\n6,4,5.2\n10,0,5\n")
        run("inp volume.vtu --material isotropic:200,0.3 -o model.inp")
        run("solve volume.vtu --material isotropic:200,0.3 -o solution.npz --vtu solution.vtu")
    return folder


FILES = "made.npz volume.vti remeshed.vtp crack.vtp sizing.npz gradated.vtp volume.vtu model.inp front.csv"


def colours(path) -> int:
    """Return the number of different colours of a picture."""
    pixels = imread(io.BytesIO(path.read_bytes()))[..., :3]
    assert min(pixels.shape[:2]) > 300
    return len(np.unique((pixels.reshape(-1, 3) * 255).astype(np.uint8), axis=0))


@pytest.mark.sampled(3)
@pytest.mark.parametrize("name", [*FILES.split(), "solution.vtu"])
def test_every_stage_file_has_a_picture(stages, name, tmp_path):
    for picture in ("a.png", "b.png"):
        run(f"view {stages / name} -o {tmp_path / picture}")
    assert colours(tmp_path / "a.png") > 20
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


@pytest.mark.parametrize("name", ["gradated.vtp", "volume.vtu", "model.inp"])
def test_the_crack_is_red(stages, name, tmp_path):
    run(f"view {stages / name} -o {tmp_path / 'a.png'}")
    run(f"view {stages / 'remeshed.vtp'} -o {tmp_path / 'without.png'}")

    def reds(path):
        red, green, blue = np.moveaxis(imread(path)[..., :3], -1, 0)
        return int(((red > 0.4) & (green < 0.15) & (blue < 0.15)).sum())

    assert reds(tmp_path / "a.png") > 10 * reds(tmp_path / "without.png") + 500


def test_a_volume_of_another_program_has_a_picture(tmp_path):
    labels = np.arange(24, dtype=np.int32).reshape(4, 3, 2) // 6 + 1
    nrrd.write(str(tmp_path / "scan.nrrd"), labels, {"spacings": [1.0, 1.0, 1.0]})
    run(f"view {tmp_path / 'scan.nrrd'}")
    assert colours(tmp_path / "scan.nrrd.png") > 20


@pytest.mark.parametrize(
    ("name", "flags"),
    [
        ("scan.npy", "--axes zyx --spacing 2 2 3"),
        ("scan.npz", "--dataset grains"),
        ("scan.npz", "--spacing 2 2 3 --background grain"),
        ("scan.npz", ""),
        ("SCAN.NRRD", "--spacing 2 2 3"),
    ],
)
def test_what_import_takes_has_a_picture_with_the_flags_of_import(tmp_path, name, flags):
    labels = np.arange(24, dtype=np.int32).reshape(4, 3, 2) // 6 + 1
    if name.endswith("npy"):
        np.save(tmp_path / name, labels)
    elif name.endswith("npz"):
        np.savez(tmp_path / name, grains=labels)
    else:
        nrrd.write(str(tmp_path / name), labels, {"spacings": [1.0, 1.0, 1.0]})
    run(f"view {tmp_path / name} {flags} -o {tmp_path / 'a.png'}")
    run(f"import {tmp_path / name} {flags} --labels {tmp_path / 'labels.npz'}")
    assert colours(tmp_path / "a.png") > 20


def test_spacing_stretches_the_picture(tmp_path):
    np.savez(tmp_path / "scan.npz", labels=np.ones((4, 4, 4), int), spacing=np.ones(3))
    sizes = []
    for spacing in ("1 1 1", "1 1 4"):
        run(f"view {tmp_path / 'scan.npz'} --spacing {spacing} -o {tmp_path / 'a.png'}")
        sizes.append((imread(tmp_path / "a.png")[..., :3].mean(axis=2) < 0.9).sum())
    assert sizes[1] != sizes[0]


def test_the_picture_is_named_after_the_file(stages, monkeypatch):
    monkeypatch.chdir(stages)
    run("view crack.vtp")
    assert (stages / "crack.vtp.png").is_file()


def test_what_cannot_be_shown_is_said_in_one_line(stages, capsys):
    assert main(["view", str(stages / "islands.json")]) == 1
    assert ".json' is not a stage file's" in capsys.readouterr().err
    assert main(["view", str(stages / "solution.npz")]) == 1
    assert "view solution.vtu instead" in capsys.readouterr().err

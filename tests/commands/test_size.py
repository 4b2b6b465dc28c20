"""`craftmesh size` makes the sizing once; stages take its file as they take the flags it was made of."""

import json

import numpy as np
import pytest

from craftmesh import cli
from craftmesh.commands.mesh_flags import stored_sizing
from craftmesh.io.npz import write_labels
from craftmesh.io.vtk import write_surface
from craftmesh.remeshing.remesh import RemeshOptions, remesh
from craftmesh.sizing.sizing import median_edge
from craftmesh.types import Voxels
from craftmesh.voxels.generate import GenerateOptions, generate

SIZES = "--l-min 0.6 --l0 1 --l-max 2.5 --r0 3 --r1 6"
SPACING = (1.0, 0.5, 2.0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the surface of a small polycrystal around a void, and the crack in it."""
    path = tmp_path_factory.mktemp("size")
    options = GenerateOptions(shape=(16, 15, 14), grains=3, voids=1, void_radius=2.5, seed=2)
    voxels = generate(options)
    write_surface(path / "s.vtp", remesh(voxels, RemeshOptions())[0])
    write_labels(path / "labels.npz", Voxels(voxels.labels, SPACING, (0.0, 0.0, 0.0)))
    crack = "crack s.vtp --centre 8 0 7.3 --radius 3.5 -o crack.vtp"
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(path)
        assert cli.main(crack.split()) == 0
    return path


@pytest.fixture
def run(folder, monkeypatch, capsys):
    """Return a function that runs a command line in the folder: status and stderr."""
    monkeypatch.chdir(folder)

    def run(line: str) -> tuple[int, str]:
        status = cli.main(line.split())
        return status, capsys.readouterr().err

    return run


def test_without_l0_the_labels_give_the_voxels_edge(folder, run):
    assert run("size s.vtp --labels labels.npz -o a.npz --report a.json")[0] == 0
    found = stored_sizing(folder / "a.npz")
    assert (
        found.l0 == np.cbrt(np.prod(SPACING)) and found.l_max == 3 * found.l0 and found.r0 == 8 * found.l0
    )
    assert "cube root" in json.loads((folder / "a.json").read_text())["l0_is"]
    assert run("size s.vtp --labels labels.npz --l0 0.7 -o b.npz")[0] == 0
    assert stored_sizing(folder / "b.npz").l0 == 0.7


def test_without_labels_the_surface_gives_l0(folder, run):
    from craftmesh.io.vtk import read_surface

    assert run("size s.vtp -o c.npz")[0] == 0
    assert stored_sizing(folder / "c.npz").l0 == median_edge(read_surface(folder / "s.vtp"))


def test_all_sources_are_in_the_file(folder, run):
    (folder / "points.csv").write_text("x,y,z\n1,14,1\n")
    line = (
        f"size s.vtp --crack crack.vtp {SIZES} --around-voids --points points.csv --curvature 20 -o d.npz"
    )
    assert run(line)[0] == 0
    found = stored_sizing(folder / "d.npz")
    # sources on the front are at most l_min / 2 apart, so 0.15 away: Eq. 3 adds 0.4 * 0.15 / 3 there
    assert found.at([[1.0, 14, 1], [8.0, 3.5, 7.3]]) == pytest.approx(0.6, abs=0.02)
    assert len(found.others) == 1 and len(found.sources) > 50
    assert run("check d.npz")[0] == 0


def test_stages_do_the_same_by_file_as_by_flags(folder, run):
    assert run(f"size s.vtp --crack crack.vtp {SIZES} -o e.npz")[0] == 0
    for name, flags in (("by_flags", f"--front crack.vtp {SIZES}"), ("by_file", "--sizing e.npz")):
        of_stitch = SIZES if name == "by_flags" else flags
        assert run(f"stitch s.vtp --crack crack.vtp {of_stitch} -o {name}_s.vtp")[0] == 0
        crack = "--crack crack.vtp" if name == "by_file" else ""
        assert run(f"gradate {name}_s.vtp {flags} {crack} --passes 1 -o {name}_g.vtp")[0] == 0
        assert run(f"tetrahedralize {name}_g.vtp {flags} --chunk 1/1 -o {name}.npz")[0] == 0
    for end in ("_s.vtp", "_g.vtp"):
        assert (folder / f"by_flags{end}").read_bytes() == (folder / f"by_file{end}").read_bytes()
    tets = [np.load(folder / f"{name}.npz") for name in ("by_flags", "by_file")]
    assert len(tets[0]["tets"]) and all(
        np.array_equal(tets[0][key], tets[1][key]) for key in ("grain", "nodes", "interior", "tets")
    )


@pytest.mark.parametrize(
    "verb", ["stitch s.vtp", "gradate s.vtp", "tetrahedralize s.vtp", "assemble s.vtp c.npz"]
)
@pytest.mark.parametrize(("flags", "named"), [("--l0 2 --around-voids", "--l0, --around-voids")])
def test_a_sizing_and_flags_together_are_refused_in_one_line(run, verb, flags, named):
    status, said = run(f"{verb} --sizing gone.npz {flags} -o x.vtu")
    assert status == 1 and said.count("\n") == 1
    assert f"--sizing gone.npz has all sizes; remove {named}" in said


def test_front_and_sizing_together_are_refused(run):
    assert "remove --front" in run("gradate s.vtp --sizing e.npz --front f.csv -o x.vtp")[1]
    assert "not allowed with" in run("size s.vtp --crack crack.vtp --front f.csv -o x.npz")[1]


def test_labels_are_no_sizing(run):
    status, said = run("gradate s.vtp --sizing labels.npz -o x.vtp")
    assert status == 1 and "labels.npz: is not a sizing; expected a sizing.npz" in said

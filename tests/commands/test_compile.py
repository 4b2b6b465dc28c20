"""`craftmesh compile`: all stages run on its small models."""

import os
import subprocess
import sys
import tempfile

import pytest

from craftmesh.cli import main
from craftmesh.commands.compile import cracked_cube
from craftmesh.surface.check_surface import check_surface
from craftmesh.surface.front import front_edges


def test_the_cube_is_a_sound_surface_with_one_straight_front():
    cube = cracked_cube()
    assert check_surface(cube) == []
    assert (cube.points[front_edges(cube)][..., [0, 2]] == 3).all()


@pytest.mark.slow  # `make test` itself begins with both
@pytest.mark.parametrize("part", ["volume", "all", "gradate"])
def test_every_stage_runs_and_nothing_is_left_behind(part, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    assert main(["compile", part]) == 0
    said = capsys.readouterr().out.split()
    last = ["inp", "solve", "fracture", "depict", "grow"]
    assert said[-5:] == last or part == "gradate"
    assert ("gradate" in said) == (part != "volume")
    assert os.listdir(tmp_path) == []


OTHER_SIZES = "--l-min 0.7 --l0 1.2 --l-max 2.5 --r0 2 --r1 4"
OTHER_MODEL = "--microstructure labels.npz --material cubic:168400,121400,75400"
# other voxels, as noisy, with a penny that is tilted
OTHER = (
    "generate --shape 13 15 12 --grains 4 --seed 3 --shuffled 0.4 -o generated.npz",
    "import generated.npz --labels labels.npz --image volume.vti --islands islands.json",
    "remesh labels.npz -o remeshed.vtp",
    "crack labels.npz --centre 6 7 6.2 --normal 0 0.3 1 --radius 3 -o crack.vtp",
    f"size remeshed.vtp --crack crack.vtp --labels labels.npz {OTHER_SIZES} -o sizing.npz",
    "stitch remeshed.vtp --crack crack.vtp --sizing sizing.npz -o surface.vtp",
    "gradate surface.vtp --crack crack.vtp --sizing sizing.npz -o gradated.vtp",
    "tetrahedralize gradated.vtp --islands islands.json --sizing sizing.npz --chunk 1/1 -o part.npz",
    "assemble gradated.vtp part.npz --sizing sizing.npz -o volume.vtu --front-csv front.csv",
    "check volume.vtu --labels labels.npz --quality quality.json",
    f"inp volume.vtu {OTHER_MODEL} -o model.inp",
    f"solve volume.vtu {OTHER_MODEL} -o solution.npz --vtu solution.vtu",
    f"fracture volume.vtu solution.npz {OTHER_MODEL} --crack crack.vtp -o sif.csv",
    "grow crack.vtp sif.csv front.csv --volume labels.npz -o grown.vtp",
)


@pytest.mark.slow
def test_after_it_another_crack_with_poor_tets_compiles_nothing(tmp_path):
    kept = {"NUMBA_CACHE_DIR": tmp_path / "kernels", "PYTHONPYCACHEPREFIX": tmp_path / "modules"}
    env = os.environ | {name: str(path) for name, path in kept.items()} | {"PYTHONDONTWRITEBYTECODE": "1"}

    def run(line):
        command = [sys.executable, "-m", "craftmesh.cli", *line.split()]
        subprocess.run(command, cwd=tmp_path, env=env, check=True, capture_output=True)

    run("compile")
    modules = {path.name.partition(".")[0] for path in kept["PYTHONPYCACHEPREFIX"].rglob("*.pyc")}
    assert {"gradate", "volume", "fracture", "multiarray", "dispatcher"} <= modules
    kernels = set(kept["NUMBA_CACHE_DIR"].rglob("*.nb[ic]"))
    assert len(kernels) > 100
    for line in OTHER:
        run(line)
    new = set(kept["NUMBA_CACHE_DIR"].rglob("*.nb[ic]")) - kernels
    assert new == set()

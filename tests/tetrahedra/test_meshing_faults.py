"""Faults of input, mesher and disk on the command line: one clear line, nothing half-written, work kept."""

import json
import shutil
import subprocess
import sys

import numpy as np
import pytest
from structured_box import structured_box

from craftmesh import cli
from craftmesh.io.stage_npz import read_grain_tets, read_record
from craftmesh.io.vtk import read_surface, read_tets, write_surface, write_tets
from craftmesh.io.vtk_xml import read_dataset
from craftmesh.mesh.check_tets import check_tets
from craftmesh.types import Surface

QUICK = ["--switches", "pYQ", "--no-interior-points", "--no-optimise"]
# Runs the command line with files of at most so many bytes, as on a disk that is full beyond them.
FULL_DISK = (
    "import resource, sys; limit = int(sys.argv[1]);"
    "resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit));"
    "from craftmesh import cli; sys.exit(cli.main(sys.argv[2:]))"
)


def three_grains():
    """Grains 4, 7, 9 in a row along x."""
    return structured_box((6, 3, 3), lambda c: np.array([4, 7, 9])[c[:, 0].astype(int) // 2])[0]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with sound.vtp, and bad.vtp where the boundary of 4, 7 reaches through that of 7, 9."""
    monkeypatch.chdir(tmp_path)
    surface = three_grains()
    write_surface("sound.vtp", surface)
    points = surface.points.copy()
    points[np.flatnonzero((points == [2, 1, 1]).all(axis=1))] = [4.6, 1.3, 1.4]
    write_surface("bad.vtp", Surface(points, surface.facets, surface.sides, surface.kind))
    return tmp_path


def run(*words) -> int:
    return cli.main([str(word) for word in words])


def test_intersecting_input_names_grain_and_facets_and_shows_them(folder, capsys):
    status = run("tetrahedralize", "bad.vtp", "-o", "v.vtu", *QUICK, "--no-repair", "--fallback", "none")
    out, err = capsys.readouterr()
    # a slow machine's progress comes before
    err = err.splitlines()[-1]
    assert status == 1 and out == "" and err.startswith("craftmesh: error: ")
    assert "grain 7 could not be meshed" in err and "facets" in err and "v-failed-grain-7.vtp" in err
    marks = read_dataset("v-failed-grain-7.vtp", "PolyData").at_cells
    rows = marks["facet"][marks["at_fault"] == 1]
    # the facets at fault are those of the pulled point and those it goes through
    surface = read_surface("bad.vtp")
    assert len(rows) and all(str(row) in err for row in rows[:3])
    assert set(map(tuple, surface.sides[rows].tolist())) == {(4, 7), (7, 9)}
    assert {path.name for path in folder.glob("v*")} == {
        path.name for path in folder.glob("v-failed-grain-*.vtp")
    }


def test_intersecting_input_is_repaired_alike_in_every_chunk(folder, capsys):
    for part in (1, 2):
        assert run("tetrahedralize", "bad.vtp", "--chunk", f"{part}/2", "-o", f"{part}.npz", *QUICK) == 0
        said = capsys.readouterr().err
        assert "facets of the surface intersect" in said and f"{part}-faulty-facets.vtp" in said
        shown = read_surface(f"{part}-faulty-facets.vtp")
        assert set(map(tuple, shown.sides.tolist())) == {(4, 7), (7, 9)}
    assert run("assemble", "bad.vtp", "1.npz", "2.npz", "-o", "v.vtu", "--report", "m.json", *QUICK) == 0
    mesh = read_tets("v.vtu")
    assert check_tets(mesh) == [] and np.unique(mesh.grain).tolist() == [4, 7, 9]
    assert run("check", "v.vtu", "--meshing", "m.json", "--quality", "q.json") == 0
    meshing = json.loads((folder / "q.json").read_text())["meshing"]
    assert meshing["repair"]["faults_left"] == 0 < meshing["repair"]["points_moved"]
    assert meshing["failed"] == {} and meshing["whole_model"] is None


def test_a_grain_that_fails_everywhere_ends_in_a_mesh_of_the_whole_model(folder, capsys):
    flags = [*QUICK, "--no-repair"]
    for part in (1, 2):
        assert run("tetrahedralize", "bad.vtp", "--chunk", f"{part}/2", "-o", f"{part}.npz", *flags) == 0
    assert "warning: grain 7 could not be meshed" in capsys.readouterr().err
    done = [one.grain for part in (1, 2) for one in read_grain_tets(f"{part}.npz")]
    left = [grain for part in (1, 2) for grain in read_record(f"{part}.npz")["left"]]
    assert 7 in left and sorted(done + left) == [4, 7, 9]
    assert run("assemble", "bad.vtp", "1.npz", "2.npz", "-o", "v.vtu", "--report", "m.json", *flags) == 0
    err = capsys.readouterr().err
    assert "warning: every attempt of tetgen failed at grains" in err and "pytetwild" in err
    mesh = read_tets("v.vtu")
    assert check_tets(mesh) == [] and np.unique(mesh.grain).tolist() == [4, 7, 9]
    meshing = json.loads((folder / "m.json").read_text())["meshing"]
    assert meshing["grains_failed"] == len(left) and len(meshing["failed"]["7"]["attempts"]) >= 2
    assert meshing["whole_model"]["tets"] > 0


def test_without_fallback_a_chunk_keeps_its_other_grains_and_the_assembly_fails(folder, capsys):
    flags = [*QUICK, "--no-repair", "--fallback", "none"]
    assert run("tetrahedralize", "bad.vtp", "--chunk", "1/1", "-o", "c.npz", *flags) == 0
    assert "warning: grain 7 could not be meshed" in capsys.readouterr().err
    left = read_record("c.npz")["left"]
    assert 7 in left and [one.grain for one in read_grain_tets("c.npz")] == sorted({4, 7, 9} - set(left))
    assert run("assemble", "bad.vtp", "c.npz", "-o", "v.vtu", *flags) == 1
    last = capsys.readouterr().err.splitlines()[-1]
    assert "grain 7: " in last and "fallback is none" in last and not (folder / "v.vtu").exists()


def test_mesher_tetwild_leaves_all_grains_to_the_whole_model(folder, capsys):
    assert run("tetrahedralize", "sound.vtp", "--chunk", "1/1", "-o", "c.npz", "--mesher", "tetwild") == 0
    assert read_grain_tets("c.npz") == [] and read_record("c.npz")["left"] == [4, 7, 9]
    assert run("assemble", "sound.vtp", "c.npz", "-o", "v.vtu", "--mesher", "tetwild") == 0
    mesh = read_tets("v.vtu")
    assert check_tets(mesh) == [] and np.unique(mesh.grain).tolist() == [4, 7, 9]
    assert "warning" not in capsys.readouterr().err


def test_a_failure_of_the_whole_model_too_is_one_line(folder, capsys):
    flags = [*QUICK, "--no-repair", "--whole-time-limit", "0.1"]
    assert run("tetrahedralize", "bad.vtp", "-o", "v.vtu", *flags) == 1
    last = capsys.readouterr().err.splitlines()[-1]
    assert last.startswith("craftmesh: error: every attempt of tetgen failed at grains")
    assert "no answer within 0.1 s" in last and not (folder / "v.vtu").exists()


def on_full_disk(limit, *words):
    return subprocess.run(
        [sys.executable, "-c", FULL_DISK, str(limit), *map(str, words)],
        capture_output=True,
        text=True,
        timeout=120,
    )


@pytest.mark.slow
def test_a_full_disk_leaves_nothing_half_written_and_keeps_other_chunks(folder):
    assert run("tetrahedralize", "sound.vtp", "--chunk", "1/2", "-o", "1.npz", *QUICK) == 0
    kept = (folder / "1.npz").read_bytes()
    before = {path.name for path in folder.iterdir()}
    done = on_full_disk(3000, "tetrahedralize", "sound.vtp", "--chunk", "2/2", "-o", "2.npz", *QUICK)
    assert done.returncode == 1 and "Traceback" not in done.stderr
    last = done.stderr.splitlines()[-1]
    assert last.startswith("craftmesh: error: 2.npz: cannot be written (File too large)")
    assert {path.name for path in folder.iterdir()} == before
    assert (folder / "1.npz").read_bytes() == kept
    # with space again only that chunk is missing
    assert run("tetrahedralize", "sound.vtp", "--chunk", "2/2", "-o", "2.npz", *QUICK) == 0
    assert run("assemble", "sound.vtp", "1.npz", "2.npz", "-o", "v.vtu") == 0
    size = (folder / "v.vtu").stat().st_size
    (folder / "v.vtu").unlink()
    before = {path.name for path in folder.iterdir()}
    done = on_full_disk(size // 2, "assemble", "sound.vtp", "1.npz", "2.npz", "-o", "v.vtu")
    assert done.returncode == 1 and done.stderr.splitlines()[-1].startswith("craftmesh: error: v.vtu")
    assert {path.name for path in folder.iterdir()} == before


@pytest.mark.skipif(shutil.which("tetgen") is None, reason="the program tetgen is not installed")
def test_a_disk_full_for_the_mesher_is_no_fault_of_the_grain(folder):
    words = ("tetrahedralize", "sound.vtp", "--chunk", "1/1", "-o", "c.npz", "--mesher", "tetgen-cli")
    done = on_full_disk(200, *words, *QUICK)
    assert done.returncode == 1 and "Traceback" not in done.stderr
    assert "a worker process cannot write its files (File too large)" in done.stderr
    assert not (folder / "c.npz").exists()


def test_a_broken_write_keeps_the_old_file(folder, monkeypatch, capsys):
    mesh = structured_box((1, 1, 1), lambda c: np.ones(len(c), int))
    from craftmesh.assembly.assemble import assemble

    write_tets("v.vtu", assemble(*mesh)[0])
    old = (folder / "v.vtu").read_bytes()
    monkeypatch.setattr("os.replace", no_space)
    assert run("tetrahedralize", "sound.vtp", "-o", "v.vtu", *QUICK) == 1
    assert "v.vtu: cannot be written (No space left on device)" in capsys.readouterr().err
    assert (folder / "v.vtu").read_bytes() == old and not list(folder.glob(".tmp-*"))


def no_space(*_):
    raise OSError(28, "No space left on device")

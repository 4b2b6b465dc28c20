"""`--front-csv`: the ordered front beside the mesh, whichever verb makes it."""

import pytest
from structured_box import hexagon, plane_crack, structured_box

from craftmesh import cli
from craftmesh.io.front_csv import read_front
from craftmesh.io.vtk import write_surface

QUICK = ["--switches", "pYQ", "--no-interior-points", "--no-optimise"]


@pytest.mark.slow
def test_tetrahedralize_writes_the_front_that_assemble_does(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    crack = plane_crack(2, 3, hexagon((3, 3), 2))
    write_surface("s.vtp", structured_box((6, 6, 6), lambda c: 1 + (c[:, 0] > 3), crack)[0])
    assert cli.main(["tetrahedralize", "s.vtp", "-o", "v.vtu", "--front-csv", "one.csv", *QUICK]) == 0
    for part in (1, 2):
        words = ["--chunk", f"{part}/2", "-o", f"{part}.npz"]
        assert cli.main(["tetrahedralize", "s.vtp", *words, *QUICK]) == 0
    words = ["-o", "w.vtu", "--front-csv", "two.csv", *QUICK]
    assert cli.main(["assemble", "s.vtp", "1.npz", "2.npz", *words]) == 0
    assert (tmp_path / "one.csv").read_bytes() == (tmp_path / "two.csv").read_bytes()
    assert (tmp_path / "v.vtu").read_bytes() == (tmp_path / "w.vtu").read_bytes()
    assert len(read_front(tmp_path / "one.csv")["node"]) > 6


def test_a_chunk_has_no_front(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_surface("s.vtp", structured_box((2, 2, 2), lambda c: 1 + (c[:, 0] > 1))[0])
    words = ["--chunk", "1/2", "-o", "1.npz", "--front-csv", "front.csv"]
    assert cli.main(["tetrahedralize", "s.vtp", *words]) == 1
    assert "--front-csv needs all grains" in capsys.readouterr().err
    assert not list(tmp_path.glob("*.csv")) and not list(tmp_path.glob("*.npz"))

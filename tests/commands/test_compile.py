"""`craftmesh compile`: all stages run on its small models."""

import os
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

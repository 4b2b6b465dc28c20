"""What a plan says of cracks that the stages will refuse, and what these say."""

import numpy as np
import pytest

from craftmesh.cli import main
from craftmesh.commands.plan import fault_of
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.series import prescribed_crack
from craftmesh.errors import CraftmeshError
from craftmesh.insertion.insert import insert_crack
from craftmesh.remeshing.remesh import remesh
from craftmesh.sizing.sizing import SizingOptions, sizing_for
from craftmesh.types import Voxels

SIZING = sizing_for(None, np.zeros((0, 3)), SizingOptions(l0=1.0, l_min=0.8))


def notched() -> Voxels:
    labels = np.ones((14, 14, 14), np.int32)
    labels[7:] = 2
    labels[:, :7, 5:9] = 0
    return Voxels(labels, (1, 1, 1), (0, 0, 0))


CRACKS = {
    "at the root": ((7.2, 7.0, 7.2), 3.0, "", ""),
    "in the notch, at the face": ((7.2, 0.0, 7.2), 3.0, "in no material", "the crack lies in no grain"),
    "in the notch": ((7.2, 3.5, 7.2), 2.0, "in no material", "the crack lies in no grain"),
    "along a face of the box": ((7.2, 0.0, 0.1), 3.0, "from the box face ZMIN", "ZMIN"),
}


@pytest.mark.parametrize("name", CRACKS)
def test_a_plan_foresees_what_the_insertion_refuses(name):
    centre, radius, said, refused = CRACKS[name]
    voxels = notched()
    crack = prescribed_crack(voxels.box, CrackOptions(centre=centre, radius=radius))
    fault = fault_of({"mine": crack}, voxels, SIZING.l_min)
    assert (said in fault and "crack mine" in fault) if said else not fault
    surface, _ = remesh(voxels)
    if refused:
        with pytest.raises(CraftmeshError, match=refused):
            insert_crack(surface, crack, SIZING)
    else:
        insert_crack(surface, crack, SIZING)


def test_a_plan_goes_on_to_name_every_case_whose_crack_lies_outside_the_box(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "c.yaml").write_text("""
cases: c.tsv
generate: {shape: [12, 9, 8], grains: 3}
sizing: {l0: 1.5, l_min: 1.0, l_max: 3.0, r0: 2.0, r1: 4.0}
cracks:
  near: {centre: [6.0, 0.0, 4.2], radius: 3.5}
  away: {centre: [60.0, 0.0, 4.2], radius: 3.5}
  above: {centre: [6.0, 0.0, 8.0], radius: 3.5}
""")
    rows = ["case\tmicrostructure\tcrack\tincrements", "a\tsynthetic\taway\t1", "b\tsynthetic\tnear\t1"]
    (tmp_path / "c.tsv").write_text("\n".join([*rows, "c\tsynthetic\tnear,above\t1"]) + "\n")
    assert main(["plan", "c.yaml"]) == 1
    said = capsys.readouterr().out
    assert "note: case a: crack away will be refused: the crack lies outside the box" in said
    assert "note: case c: crack above will be refused: the crack lies outside the box" in said
    assert "case b: " in said and "note: case b: crack near will" not in said

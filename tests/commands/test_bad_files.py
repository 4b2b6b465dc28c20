"""A file that is not what a verb reads ends in one line that names it, and nothing is written."""

import json

import numpy as np
import pytest
from shown_models import cracked_box

from craftmesh.assembly.assemble import refuse_other_surface
from craftmesh.cli import main
from craftmesh.errors import CraftmeshError
from craftmesh.io.stage_npz import write_solution_vtu, write_solutions
from craftmesh.io.vtk import write_tets
from craftmesh.types import GrainTets, Solution, Surface

# {in.SUFFIX} stands for the file that is bad, OUT for a folder for what is written
LINES = [
    *(
        f"init {{in.{suffix}}} -o OUT/first.yaml"
        for suffix in ("npz", "dream3d", "vti", "tesr", "mha", "nrrd")
    ),
    *(
        f"import {{in.{suffix}}} --labels OUT/labels.npz"
        for suffix in ("npz", "h5", "dream3d", "vti", "tif")
    ),
    "remesh {in.npz} -o OUT/remeshed.vtp",
    "crack {in.vtp} -o OUT/crack.vtp --centre 1 1 1 --radius 1",
    "size {in.vtp} -o OUT/sizing.npz",
    "preview {in.vtp} {in.vtp} -o OUT/crack.png",
    "stitch {in.vtp} -o OUT/surface.vtp",
    "stitch {in.stl} -o OUT/surface.vtp",
    "gradate {in.vtp} -o OUT/gradated.vtp",
    "tetrahedralize {in.vtp} -o OUT/tets.npz",
    "assemble {in.vtp} {in.npz} -o OUT/volume.vtu",
    "inp {in.vtu} -o OUT/model.inp",
    "solve {in.vtu} -o OUT/solution.npz",
    "fracture {in.vtu} {in.npz} --crack {in.vtp} -o OUT/sif.csv",
    "grow {in.vtp} {in.csv} {in.csv} --volume {in.npz} -o OUT/grown.vtp",
    "export {in.vtu} -o OUT/model.msh",
    *(f"check {{in.{suffix}}}" for suffix in ("vtp", "vtu", "npz", "json", "csv")),
    *(f"view {{in.{suffix}}} -o OUT/seen.png" for suffix in ("vtp", "vtu", "npz", "inp", "csv")),
    "depict {in.vtu} -o OUT/pictures",
    "report OUT --campaign {in.json} -o OUT/report.html",
    "plan {in.yaml}",
    "import-config {in.xml} -o OUT/config.yaml",
]
KINDS = {
    "missing": None,
    "empty": b"",
    "bytes": bytes(range(256)) * 8,
    "text": b"hello\nworld, 1 2 3\n",
    "hdf5, cut short": b"\x89HDF\r\n\x1a\n" + bytes(40),
    "zip, cut short": b"PK\x03\x04" + bytes(40),
    "xml, cut short": b'<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0"><PolyData>',
}


def refusal(words, capsys) -> str:
    """Return the one line in which a call of the command line ends."""
    assert main([str(word) for word in words]) == 1
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 1 and lines[0].startswith("craftmesh: error: "), lines
    return lines[0]


@pytest.mark.parametrize("kind", [*KINDS, "folder"])
@pytest.mark.parametrize("line", LINES)
def test_a_bad_file_is_one_line_that_names_it(line, kind, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "OUT").mkdir()
    words = [word[1:-1] if word[0] == "{" else word for word in line.split()]
    named = {word for word in words if word.startswith("in.")}
    for name in named:
        if kind == "folder":
            (tmp_path / name).mkdir()
        elif KINDS[kind] is not None:
            (tmp_path / name).write_bytes(KINDS[kind])
    said = refusal(words, capsys)
    assert any(name in said for name in named), said
    assert list((tmp_path / "OUT").iterdir()) == []


def test_a_deck_that_was_cut_short_is_refused_with_the_line(tmp_path, capsys):
    rows = "".join(f"{n}, {n}.5, 0., 1.\n" for n in range(1, 9))
    (tmp_path / "model.inp").write_text(f"*HEADING\nm\n*NODE\n{rows[:-5]}\n")
    assert "model.inp: line 3: 31 numbers do not fill rows of 4" in refusal(
        ["check", tmp_path / "model.inp"], capsys
    )


def test_a_solution_of_another_mesh_is_refused(tmp_path, capsys):
    mesh = cracked_box()
    write_tets(tmp_path / "volume.vtu", mesh)
    other, zero = mesh.points[:-5], np.zeros((len(mesh.points) - 5, 3))
    write_solutions(tmp_path / "solution.npz", {"": Solution(zero, zero)})
    tets = mesh.tets[(mesh.tets < len(other)).all(axis=1)]
    grain, node = np.ones(len(tets), np.int32), np.arange(1, len(other) + 1)
    stress = np.zeros((len(other), 6))
    write_solution_vtu(tmp_path / "solution.vtu", other, tets, grain, node, zero, stress)
    flags = ["--solution", tmp_path / "solution.npz", "-o", tmp_path / "pictures"]
    said = refusal(["depict", tmp_path / "volume.vtu", *flags], capsys)
    assert f"{len(other)} nodes, but the mesh has {len(mesh.points)}" in said
    assert not (tmp_path / "pictures").exists()


def test_what_was_asked_for_is_refused_where_it_lacks_a_key(tmp_path, capsys):
    (tmp_path / "asked.json").write_text(json.dumps({"cases": {}}))
    words = ["report", tmp_path, "--campaign", tmp_path / "asked.json", "-o", tmp_path / "page.html"]
    assert "asked.json: has the keys cases; expected campaign, config and cases" in refusal(words, capsys)


def test_tetrahedra_of_another_surface_are_refused():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], float)
    facets = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    surface = Surface(points, facets, np.tile([7, 0], (4, 1)), np.full(4, 9))
    tets = GrainTets(7, np.arange(4), np.zeros((0, 3)), np.array([[0, 1, 2, 3]]))
    refuse_other_surface(surface, [tets])
    refuse_other_surface(surface, [])
    for nodes in ([0, 1, 2, 4], [0, 1, 2, 40]):
        with pytest.raises(CraftmeshError, match=r"grain 7: .*tetrahedralize again"):
            refuse_other_surface(surface, [GrainTets(7, np.array(nodes), np.zeros((0, 3)), tets.tets)])
    with pytest.raises(CraftmeshError, match=r"grain 8: .*not the 0 that this surface gives it"):
        refuse_other_surface(surface, [GrainTets(8, np.arange(4), np.zeros((0, 3)), tets.tets)])

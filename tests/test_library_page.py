"""The snippets of docs/library.md run as they stand."""

import re
from pathlib import Path

import meshio
import numpy as np
import pytest
from structured_box import structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.surface.check_surface import check_surface
from craftmesh.types import CRACK

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGE = DOCS / "library.md"


def part():
    """A mesh as Gmsh writes it: 3 x 3 x 4 cells, two of them along a physical group in the middle."""
    mesh = assemble(*structured_box((3, 3, 4), lambda centres: np.ones(len(centres), int)))[0]
    faces = mesh.tets[:, [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]].reshape(-1, 3)
    corners = mesh.points[faces]
    inside = (corners[..., 2] == 2).all(axis=1) & (corners[..., 0].max(axis=1) <= 2)
    crack = np.unique(np.sort(faces[inside], axis=1), axis=0)
    tags = [np.full(len(mesh.tets), 1, np.int32), np.full(len(crack), 2, np.int32)]
    return meshio.Mesh(
        mesh.points,
        [("tetra", mesh.tets), ("triangle", crack)],
        cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
        field_data={"CRACK": np.array([2, 2]), "BODY": np.array([1, 3])},
    )


def snippets(page):
    return re.findall(r"```python\n(.*?)```", page.read_text(), flags=re.S)


def run_snippets(page, names):
    for snippet in snippets(page):
        exec(compile(snippet, str(page), "exec"), names)


def test_the_mesh_of_the_first_hour_is_a_sound_surface():
    names: dict = {}
    run_snippets(DOCS / "first_hours.md", names)
    assert check_surface(names["surface"]) == []


def test_from_labels_to_the_grown_crack_are_25_lines_at_most():
    lines = [line for snippet in snippets(PAGE)[:2] for line in snippet.splitlines() if line.strip()]
    assert "grow_crack" in lines[-3] and len(lines) <= 25


def test_every_snippet_runs_and_does_what_the_page_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    meshio.gmsh.write("part.msh", part(), "2.2", binary=True)
    names: dict = {}
    run_snippets(PAGE, names)
    assert len(names["opened"].point_sets["CRACK_FRONT"]) == 4
    assert "CRACK_LIP_B" in meshio.read("opened.msh").field_data
    assert (tmp_path / "model.inp").stat().st_size > 1e5 and "CRACK_LIP_A" in names["body"].face_sets
    assert names["counts"]["crack_area"] == pytest.approx(np.pi * 3.5**2 / 2, rel=0.01)  # chords
    grown, flat_crack = names["grown"], names["given"]
    assert grown.ended == "" and len(grown.crack.triangles) > len(flat_crack.triangles)
    before, after = names["growth"]["area"]
    # the half front goes on by 1; at its ends it kinks, and is cut by the face
    assert after - before == pytest.approx(np.pi * (4.5**2 - 3.5**2) / 2, rel=0.05)
    assert names["solid"].cells_dict["tetra"].shape[0] == len(names["body"].grain)
    assert len(names["flat"].faces) == names["shown"].n_cells == len(names["fitted"].facets)
    assert names["cracked"].kind.max() == CRACK and names["gradated"].kind.max() == CRACK

"""The notebooks run as they stand, with public names and what `pip install craftmesh` brings."""

import ast
import importlib.util
import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest

import craftmesh
from craftmesh.io.vtk import read_surface

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "examples" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
BROUGHT = {"craftmesh", "matplotlib", "numpy", "pyvista", "scipy", "trimesh"}
NUMBER = re.compile(r"\d[\d.e+-]*")


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))


def code_of(notebook):
    cells = (cell for cell in notebook["cells"] if cell["cell_type"] == "code")
    return ["".join(cell["source"]) for cell in cells]


def said_by(notebook):
    """Return what each code cell prints, less its numbers, and whether it draws."""
    cells = (cell["outputs"] for cell in notebook["cells"] if cell["cell_type"] == "code")
    return [
        [NUMBER.sub("0", "".join(one["text"])) if "text" in one else "picture" for one in outputs]
        for outputs in cells
    ]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_takes_public_names_and_packages_that_come_along(path):
    notebook = read(path)
    assert notebook["nbformat"] == 4 and path.stat().st_size < 150_000
    nodes = [node for code in code_of(notebook) for node in ast.walk(ast.parse(code))]
    imported = {name.name for node in nodes if isinstance(node, ast.Import) for name in node.names}
    imported |= {node.module for node in nodes if isinstance(node, ast.ImportFrom)}
    assert {name.split(".")[0] for name in imported} <= BROUGHT | sys.stdlib_module_names
    attributes = [node for node in nodes if isinstance(node, ast.Attribute)]
    named = {node.attr for node in attributes if getattr(node.value, "id", "") == "cm"}
    assert named and named <= set(craftmesh.__all__)
    assert "picture" in [one for outputs in said_by(notebook) for one in outputs]


def executed(name, folder, monkeypatch):
    """Run a notebook in a folder; return its names, and see that it says what is kept in it."""
    spec = importlib.util.spec_from_file_location("execute", FOLDER / "execute.py")
    execute = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(execute)
    monkeypatch.chdir(folder)
    notebook = read(FOLDER / f"{name}.ipynb")
    kept = said_by(notebook)
    names = execute.execute(notebook)
    assert said_by(notebook) == kept
    return names


@pytest.mark.slow
def test_an_stl_folder_becomes_a_gradated_surface(tmp_path, monkeypatch):
    names = executed("stl_folder", tmp_path, monkeypatch)
    assert len(list(tmp_path.glob("grains/*.stl"))) == len(names["gradated"].grains) == 12
    assert craftmesh.check_surface(read_surface(tmp_path / "gradated.vtp")) == []


@pytest.mark.slow
def test_a_pyvista_mesh_becomes_a_deck_with_an_open_crack(tmp_path, monkeypatch):
    names = executed("pipe", tmp_path, monkeypatch)
    assert names["counts"]["crack_area"] == pytest.approx(np.pi / 2, rel=0.01)  # of the bore's chords
    assert "CRACK_FRONT" in (tmp_path / "pipe.inp").read_text()


@pytest.mark.slow
def test_voxels_of_a_foam_become_a_deck(tmp_path, monkeypatch):
    names = executed("foam", tmp_path, monkeypatch)
    assert len(np.unique(names["body"].grain)) == 8
    assert "EXTERIOR" in (tmp_path / "foam.inp").read_text()

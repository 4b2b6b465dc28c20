"""Things have a picture in a notebook, with their line of text, and `.plot()` with and without pyvista."""

import base64
import io
import re
import sys

import numpy as np
import pytest
from matplotlib.image import imread
from shown_models import cracked_box
from structured_box import structured_box

import craftmesh
from craftmesh.report import notebook
from craftmesh.voxels.generate import GenerateOptions, generate

FRONT = np.array([2, 3])


def things():
    surface, _ = structured_box((2, 2, 2), lambda centres: 1 + (centres[:, 0] > 1))
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0.2], [0, 1, 0]])
    crack = craftmesh.Crack(square, [[0, 1, 2], [0, 2, 3]], (FRONT,))
    return [generate(GenerateOptions(shape=(6, 5, 4), grains=3)), surface, crack, cracked_box()]


THINGS = pytest.mark.parametrize("thing", things(), ids=lambda thing: type(thing).__name__)


@THINGS
def test_a_cell_shows_a_picture_and_the_line_of_text(thing):
    html = thing._repr_html_()
    assert html == thing._repr_html_() and "&lt;" not in html
    assert f"<code>{repr(thing)}</code>" in html and "\n" not in repr(thing)
    found = re.search(r'src="data:image/webp;base64,([^"]+)"', html)
    pixels = imread(io.BytesIO(base64.b64decode(found[1])), format="webp")
    assert len(np.unique(pixels.reshape(-1, pixels.shape[2]), axis=0)) > 20


@THINGS
def test_without_matplotlib_the_line_of_text_stays(thing, monkeypatch):
    for name in [name for name in sys.modules if name.startswith(("matplotlib", "craftmesh.report."))]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    html = thing._repr_html_()
    assert repr(thing) in html and "<img" not in html


@THINGS
def test_plot_without_pyvista_is_a_picture(thing, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    assert thing.plot()._repr_png_().startswith(b"\x89PNG")


@THINGS
def test_pyvista_gets_every_cell_with_its_grain(thing):
    pyvista = pytest.importorskip("pyvista")
    made = notebook.dataset(thing, pyvista)
    if isinstance(thing, craftmesh.Voxels):
        wanted = thing.labels[thing.labels > 0]
    elif isinstance(thing, craftmesh.Surface):
        wanted = thing.sides.max(axis=1)
    else:
        wanted = thing.grain if isinstance(thing, craftmesh.TetMesh) else np.zeros(len(thing.triangles))
    assert sorted(made.cell_data["grain"]) == sorted(wanted.ravel())
    box = (
        thing.box
        if hasattr(thing, "box")
        else np.stack([thing.points.min(axis=0), thing.points.max(axis=0)])
    )
    assert made.bounds == pytest.approx(box.T.ravel())


def test_options_of_plot_are_pyvistas(monkeypatch):
    pyvista = pytest.importorskip("pyvista")
    given = {}
    monkeypatch.setattr(pyvista.UnstructuredGrid, "plot", lambda self, **options: given.update(options))
    cracked_box().plot(show_edges=False, notebook=False)
    assert given == {"show_edges": False, "notebook": False, "cmap": "tab20", "scalars": "grain"}

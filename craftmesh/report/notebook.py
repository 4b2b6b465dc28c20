"""Voxels, surfaces, cracks and meshes in a notebook: as pictures in HTML, and interactive by pyvista."""

from html import escape
from importlib import import_module
from typing import Any

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mesh.mesh_sets import is_lip
from craftmesh.types import Crack, Surface, TetMesh, Voxels

TETRA = 10  # VTK's number of the cell with four nodes


class Picture:
    """A .png that a notebook shows."""

    def __init__(self, png: bytes) -> None:
        self.png = png

    def _repr_png_(self) -> bytes:
        return self.png


def html(thing: Voxels | Surface | Crack | TetMesh) -> str:
    """Return HTML with a picture and the repr of an object; without the picture if it cannot be made.

    A picture needs the extra `pictures`.
    """
    words = f"<figcaption><code>{escape(repr(thing))}</code></figcaption>"
    try:
        from craftmesh.report.pictures import webp_uri  # here because matplotlib is an extra

        image = f'<img alt="" style="max-width: 100%" src="{webp_uri(picture(thing))}">'
    except CraftmeshError:
        image = ""
    return f"<figure>{image}{words}</figure>"


def plot(thing: Voxels | Surface | Crack | TetMesh, **options: Any) -> Any:
    """Show an object by pyvista's `plot` with the given options; return a Picture without pyvista."""
    try:
        pyvista = import_module("pyvista")  # from the extra tetwild or installed by the user
    except ModuleNotFoundError:
        return Picture(picture(thing))
    shown = dict(show_edges=not isinstance(thing, Voxels), cmap="tab20", scalars="grain") | options
    return dataset(thing, pyvista).plot(**shown)


def picture(thing: Voxels | Surface | Crack | TetMesh) -> bytes:
    """Return a .png of an object, by the function in `report.views` for its type."""
    # here because matplotlib is an extra
    from craftmesh.report import views

    if isinstance(thing, Voxels):
        return views.labels_picture(thing)
    if isinstance(thing, Surface):
        return views.surface_picture(thing)
    if isinstance(thing, Crack):
        return views.crack_picture(thing)
    lips = [nodes for name, nodes in thing.node_sets.items() if is_lip(name)]
    nodes = np.concatenate([np.zeros(0, np.int64), *lips])
    return views.tets_picture(thing.points, thing.tets, thing.grain, nodes)


def dataset(thing: Voxels | Surface | Crack | TetMesh, pyvista: Any) -> Any:
    """Return an object as a data set of the module `pyvista`, with the cell array `grain`.

    Voxels without a grain are left out; facets between two grains have the larger id, cracks have 0.
    """
    if isinstance(thing, Voxels):
        shape = np.array(thing.labels.shape) + 1
        grid = pyvista.ImageData(dimensions=shape, spacing=thing.spacing, origin=thing.origin)
        grid.cell_data["grain"] = thing.labels.ravel(order="F")
        return grid.threshold(0.5, scalars="grain")  # without voids and what lies outside
    if isinstance(thing, TetMesh):
        made = pyvista.UnstructuredGrid({TETRA: thing.tets[:, :4]}, thing.points)
        made.cell_data["grain"] = thing.grain
        return made
    if isinstance(thing, Surface):
        facets, grain = thing.facets, thing.sides.max(axis=1)
    else:
        facets, grain = thing.triangles, np.zeros(len(thing.triangles), np.int32)
    made = pyvista.PolyData.from_regular_faces(thing.points, facets)
    made.cell_data["grain"] = grain
    return made

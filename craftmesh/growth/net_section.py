"""Mean stress over the net section: what a crack leaves of a section normal to the largest tension."""

from collections.abc import Mapping

import numpy as np

from craftmesh.growth.options import GrowthOptions
from craftmesh.mechanics.materials import COMPONENT
from craftmesh.mechanics.model import ElasticModel
from craftmesh.mechanics.stress import mean_stresses
from craftmesh.mesh.mesh_sets import lip_faces
from craftmesh.mesh.tet_connectivity import face_nodes, tet_volumes
from craftmesh.surface.measure import area_vectors
from craftmesh.types import TetMesh


def largest_net_stress(
    model: ElasticModel, fields: Mapping[str, np.ndarray], options: GrowthOptions, first: str
) -> float:
    """Return the largest mean stress over the net section (`net_stress`) at both ends of all load cycles.

    fields: displacements (n, 3) by load case; first: the load case that a load without a name stands for.
    """
    loads = {load for block in options.cycles() for load in (block.largest, block.smallest)}
    models = model.by_load()
    return max(net_stress(models[name or first], factor * fields[name or first]) for factor, name in loads)


def net_stress(model: ElasticModel, displacement: np.ndarray) -> float:
    """Return the mean tension over the net section under a displacement field (n, 3).

    The gross section goes through the middle of the crack, perpendicular to the largest principal stress of
    the body's mean stress. The net section is this section without the crack's projection on it; it carries
    the same force. The result is inf if the projection is at least as large as the section.
    """
    mesh = model.mesh
    tension, axes = np.linalg.eigh(mean_stresses(model, displacement)[COMPONENT])
    normal = axes[:, 2]
    lip, _ = lip_faces(mesh.face_sets)
    corners = face_nodes(mesh.tets[:, :4], lip).reshape(len(lip), -1)[:, :3]
    areas = area_vectors(mesh.points, corners)
    weights = np.linalg.norm(areas, axis=1)
    middle = weights @ mesh.points[corners].mean(axis=1) / weights.sum()
    gross, lost = section_area(mesh, middle, normal), float(np.abs(areas @ normal).sum())
    return float(tension[2] * gross / (gross - lost)) if lost < gross else np.inf


def section_area(mesh: TetMesh, place: np.ndarray, normal: np.ndarray) -> float:
    """Return the area of the mesh's section through a place (3,), perpendicular to a unit `normal`.

    A tetrahedron's section is its volume times the quadratic B-spline on the heights of its corners, by the
    recursion of de Boor.
    """
    tets = mesh.tets[:, :4]
    height = np.sort((mesh.points[tets] - place) @ normal, axis=1)
    gap = np.diff(height, axis=1)
    inside = (height[:, :-1] <= 0) & (height[:, 1:] > 0)
    spline = np.where(inside, 1 / np.where(inside, gap, 1.0), 0.0)
    for order in (2, 3):
        low, high = height[:, :-order], height[:, order:]
        wide = np.maximum(high - low, np.finfo(float).tiny)
        spline = order / (order - 1) * (high * spline[:, 1:] - low * spline[:, :-1]) / wide
    return float(tet_volumes(mesh.points, tets) @ spline[:, 0])

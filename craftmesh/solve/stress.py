"""Stresses at the nodes, averaged inside each grain and never across its boundary."""

from dataclasses import dataclass

import numpy as np

from craftmesh.mechanics.eigenstrains import components
from craftmesh.mechanics.materials import COMPONENT
from craftmesh.mechanics.model import ElasticModel
from craftmesh.mesh.integration import DECK_RULE, determinants, jacobians, parts_of, tet_rule
from craftmesh.mesh.tet_connectivity import EDGE_CORNERS, tet_volumes
from craftmesh.solve.problem import Elements, elements_of


@dataclass(frozen=True, eq=False)
class GrainStress:
    """node (p,): the mesh's node that each point is; tets (m, k): the elements on these points.

    A node in several grains is a point in each. stress (p, 6): 11, 22, 33, 12, 13, 23 in the sample's axes.
    """

    node: np.ndarray
    tets: np.ndarray
    stress: np.ndarray


def grain_stress(model: ElasticModel, displacement: np.ndarray) -> GrainStress:
    """Return the stresses of a displacement (n, 3).

    They go linearly from the integration points to the nodes of each element, and a node takes the mean of
    its grain's elements, weighted by their volumes.
    """
    mesh = model.mesh
    elements = elements_of(model, DECK_RULE)
    key = elements.part[:, None] * len(mesh.points) + mesh.tets
    found, point = np.unique(key, return_inverse=True)
    tets = point.reshape(mesh.tets.shape)
    stress, volume = np.zeros((len(found), 6)), np.zeros(len(found))
    spread = _to_nodes(mesh.tets.shape[1], elements.rule)
    for rows in parts_of(np.arange(len(tets))):
        own, size = _at_points(elements, displacement, rows)
        np.add.at(stress, tets[rows], size[:, None, None] * (spread @ own))
        np.add.at(volume, tets[rows], size[:, None])
    part, node = np.divmod(found, len(mesh.points))
    free = np.einsum("gij,gj->gi", elements.stiffness, components(model.eigenstrain()))
    return GrainStress(node, tets, stress / volume[:, None] - free[part])


def _at_points(
    elements: Elements, displacement: np.ndarray, rows: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return stresses (e, q, 6) at the integration points of elements `rows`, and their volumes (e,)."""
    points, tets, part, stiffness, slopes, weights = elements.tables
    jacobian = jacobians(points, tets[rows], slopes)
    moved = displacement[tets[rows]][:, None].swapaxes(2, 3) @ slopes @ np.linalg.inv(jacobian)
    strain = components((0.5 * (moved + moved.swapaxes(2, 3))).reshape(-1, 3, 3))
    stress = strain.reshape(len(rows), -1, 6) @ stiffness[part[rows]]
    return stress, determinants(jacobian) @ weights


def mean_stress(model: ElasticModel, displacement: np.ndarray) -> float:
    """Return the mean over the body of the principal stress that is largest by size: of tension, that."""
    found = grain_stress(model, displacement)
    matrix = found.stress[:, COMPONENT]
    size = np.abs(np.linalg.eigvalsh(matrix)[:, [0, 2]]).max(axis=1)
    corners = model.mesh.tets[:, :4]
    return float(
        np.average(size[found.tets[:, :4]].mean(axis=1), weights=tet_volumes(model.mesh.points, corners))
    )


def _to_nodes(width: int, rule: int) -> np.ndarray:
    """Return the weights (width, rule) with which values at the integration points go to the nodes."""
    if rule == 1:
        return np.ones((width, 1))
    corners = np.linalg.inv(tet_rule(rule)[0]).T
    return np.concatenate([corners, corners[EDGE_CORNERS].mean(axis=1)])

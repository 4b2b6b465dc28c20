"""Stresses at the nodes, averaged inside each grain and never across its boundary."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from craftmesh.mechanics.eigenstrains import components
from craftmesh.mechanics.materials import COMPONENT
from craftmesh.mechanics.model import ElasticModel
from craftmesh.mesh.integration import (
    DECK_RULE,
    determinants,
    jacobians,
    parts_of,
    shape_slopes,
    shape_values,
    tet_rule,
)
from craftmesh.mesh.tet_connectivity import EDGE_CORNERS, tet_volumes


@dataclass(frozen=True, eq=False)
class GrainStress:
    """Stresses at points. A node of several grains is a separate point in each of them.

    node (p,): the mesh node of each point; tets (m, k): the mesh's elements, with rows of points as nodes;
    stress (p, 6): 11, 22, 33, 12, 13, 23 in sample axes.
    """

    node: np.ndarray
    tets: np.ndarray
    stress: np.ndarray


def grain_stress(model: ElasticModel, displacement: np.ndarray) -> GrainStress:
    """Return the nodal stresses of a displacement field (n, 3), separately in each grain.

    Stresses are extrapolated linearly from the integration points to the nodes of each element. A node
    takes the mean over its grain's elements, weighted by volume. Eigenstrains of the grains are subtracted
    from the strain.
    """
    mesh, tets = model.mesh, model.mesh.tets
    part = np.searchsorted(model.grains, mesh.grain)
    found, point = np.unique(part[:, None] * len(mesh.points) + tets, return_inverse=True)
    point = point.reshape(tets.shape)
    stress, volume = np.zeros((len(found), 6)), np.zeros(len(found))
    for rows, own, weight in _at_points(model, displacement):
        spread, size = _to_nodes(tets.shape[1], own.shape[1]), weight.sum(axis=1)
        np.add.at(stress, point[rows], size[:, None, None] * (spread @ own))
        np.add.at(volume, point[rows], size[:, None])
    return GrainStress(found % len(mesh.points), point, stress / volume[:, None])


def _at_points(
    model: ElasticModel, displacement: np.ndarray
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Yield batches of elements (m,), their stresses (m, q, 6) and volumes (m, q) at q points."""
    tets, stiffness = model.mesh.tets, model.stiffness()
    part = np.searchsorted(model.grains, model.mesh.grain)
    places, weights = tet_rule(1 if tets.shape[1] == 4 else DECK_RULE)
    slopes, values = shape_slopes(places, tets.shape[1]), shape_values(places, tets.shape[1])
    free = components(model.eigenstrain())
    for rows in parts_of(np.arange(len(tets))):
        jacobian = jacobians(model.mesh.points, tets[rows], slopes)
        moved = displacement[tets[rows]][:, None].swapaxes(2, 3) @ slopes @ np.linalg.inv(jacobian)
        strain = components((0.5 * (moved + moved.swapaxes(2, 3))).reshape(-1, 3, 3))
        heat = 1.0 if model.temperature is None else (model.temperature[tets[rows]] @ values.T)[:, :, None]
        elastic = strain.reshape(len(rows), -1, 6) - heat * free[part[rows], None]
        yield rows, elastic @ stiffness[part[rows]], determinants(jacobian) * weights


def mean_stress(model: ElasticModel, displacement: np.ndarray) -> float:
    """Return the volume mean of the largest magnitude of a principal stress.

    In uniaxial loading this is the magnitude of the stress, also positive in compression.
    """
    found = grain_stress(model, displacement)
    matrix = found.stress[:, COMPONENT]
    size = np.abs(np.linalg.eigvalsh(matrix)[:, [0, 2]]).max(axis=1)
    corners = model.mesh.tets[:, :4]
    return float(
        np.average(size[found.tets[:, :4]].mean(axis=1), weights=tet_volumes(model.mesh.points, corners))
    )


def mean_stresses(model: ElasticModel, displacement: np.ndarray) -> np.ndarray:
    """Return the volume mean (6,) of the stress: 11, 22, 33, 12, 13, 23 in sample axes.

    It is integrated with the points of the deck's elements, so that the mean of a field that is solved with
    these points is in exact balance with the loads.
    """
    total, volume = np.zeros(6), 0.0
    for _, own, weight in _at_points(model, displacement):
        total += np.einsum("mq,mqi->i", weight, own)
        volume += weight.sum()
    return total / volume


def _to_nodes(width: int, rule: int) -> np.ndarray:
    """Return the weights (width, rule) that extrapolate from `rule` integration points to `width` nodes."""
    if rule == 1:
        return np.ones((width, 1))
    corners = np.linalg.inv(tet_rule(rule)[0]).T
    return np.concatenate([corners, corners[EDGE_CORNERS].mean(axis=1)])

"""The bodies of a mesh: elements that hang together by their nodes. A crack may sever it into several."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from craftmesh.mesh.tet_connectivity import tet_volumes
from craftmesh.types import TetMesh


def bodies(mesh: TetMesh) -> np.ndarray:
    """Return the number (m,) of the body that each element is in, from 0 in the order of first elements."""
    n = len(mesh.points)
    tails = np.repeat(mesh.tets[:, 0], mesh.tets.shape[1] - 1)
    heads = mesh.tets[:, 1:].ravel()
    links = coo_array((np.ones(len(heads), np.int8), (tails, heads)), shape=(n, n))
    found = connected_components(links, directed=False)[1][mesh.tets[:, 0]]
    _, first, body = np.unique(found, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[body.ravel()]


def severed_sentence(mesh: TetMesh) -> str:
    """Return how many bodies the mesh is and where all but the largest lie, '' where it is one."""
    body = bodies(mesh)
    if not body.any():
        return ""
    volume = tet_volumes(mesh.points, mesh.tets)
    size = np.bincount(body, volume)
    told = []
    for number in np.argsort(-size, kind="stable")[1:].tolist():
        own = body == number
        places = mesh.points[mesh.tets[own, :4]].mean(axis=1)
        middle = np.average(places, axis=0, weights=volume[own])
        told.append(f"volume {size[number]:.4g} round ({', '.join(f'{x:.4g}' for x in middle)})")
    return (
        f"the mesh is {len(size)} bodies, which nothing joins, as where the crack severs it; beside the "
        f"largest: {'; '.join(told)}"
    )

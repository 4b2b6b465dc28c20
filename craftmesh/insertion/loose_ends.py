"""Stretches of a front outside the body, where it does not fill its box."""

from dataclasses import replace

import numpy as np

from craftmesh.insertion.front_chain import FrontChain


def without_loose_ends(front: FrontChain, traces: np.ndarray) -> FrontChain:
    """Return the front without the edges that lead from its first and last trace (k, 2) to no other.

    An open front ends on the box. Where the body does not reach the box there is no trace to end on: the
    stretch from the last trace on is in no grain and bounds no part of the crack.
    """
    edges = front.edges
    while len(edges):
        nodes = np.concatenate([edges[:, :2].ravel(), traces.ravel()])
        loose = (np.bincount(nodes) == 1)[edges[:, :2]].any(axis=1)
        if not loose.any():
            break
        edges = edges[~loose]
    return replace(front, edges=edges)

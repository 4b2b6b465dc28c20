"""Node sets that follow from a mesh's face sets: box planes, edges and corners, lips, front."""

from collections.abc import Mapping
from itertools import combinations

import numpy as np

from craftmesh.mesh.tet_connectivity import face_nodes
from craftmesh.types import BOX_PLANES

LIPS = ("CRACK_LIP_A", "CRACK_LIP_B")


def node_sets_of(tets: np.ndarray, face_sets: Mapping, fronts: list) -> dict[str, np.ndarray]:
    """Return the node sets of the box, of the crack's lips and of its ordered fronts.

    A plane's set holds the nodes of its faces; edges (XMIN_YMIN) and corners (XMIN_YMIN_ZMIN) are
    common to two and three planes. fronts: (ordered nodes, closed?); CRACK_FRONT holds them one after
    the other, and each is CRACK_FRONT_<k> too, from 1, when there are several. Empty sets are left out.
    """
    sets = {name: _nodes(tets, face_sets[name]) for name in (*BOX_PLANES, *LIPS) if name in face_sets}
    for count in (2, 3):
        for planes in combinations([name for name in BOX_PLANES if name in sets], count):
            if len({plane[0] for plane in planes}) == count:
                common = sets[planes[0]]
                for plane in planes[1:]:
                    common = np.intersect1d(common, sets[plane], assume_unique=True)
                sets["_".join(planes)] = common
    if fronts:
        sets["CRACK_FRONT"] = np.concatenate([nodes for nodes, _ in fronts])
    if len(fronts) > 1:
        sets |= {f"CRACK_FRONT_{k}": nodes for k, (nodes, _) in enumerate(fronts, 1)}
    return {name: nodes for name, nodes in sets.items() if len(nodes)}


def _nodes(tets: np.ndarray, faces: np.ndarray) -> np.ndarray:
    return np.unique(face_nodes(tets, faces))

"""Sets of a mesh by name: lips, fronts, and the node sets that follow from the face sets."""

import re
from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np

from craftmesh.mesh.tet_connectivity import face_nodes
from craftmesh.types import BOX_PLANES

LIPS = ("CRACK_LIP_A", "CRACK_LIP_B")
NEW = "NEW"  # element set of a renewed mesh: elements that the mesh before does not have
_LIP = re.compile(r"(.+)_LIP_[AB]")
_FRONT = re.compile(r".+_FRONT(_\d+)?")


def is_lip(name: str) -> bool:
    """Return whether a face set is a lip: CRACK_LIP_A, CRACK_2_LIP_B and similar names."""
    return _LIP.fullmatch(name) is not None


def is_front(name: str) -> bool:
    """Return whether a node set is an ordered front: CRACK_FRONT, CRACK_FRONT_1, CRACK_2_FRONT."""
    return _FRONT.fullmatch(name) is not None


def lip_faces(face_sets: Mapping[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return the faces (k, 2) of all lips A, and the faces (k, 2) of all lips B, crack by crack.

    A row is an element's row and the number of its face.
    """
    none = np.zeros((0, 2), np.int64)
    lips = {name: faces for name, faces in face_sets.items() if is_lip(name)}
    a, b = (
        np.concatenate([none, *(faces for name, faces in lips.items() if name.endswith(side))])
        for side in "AB"
    )
    return a, b


def own_lips(face_sets: Mapping[str, np.ndarray], tets: np.ndarray, front: np.ndarray) -> dict:
    """Return lips A and B, as face sets by name, of the crack whose lip A has most nodes of a front (k,).

    face_sets must hold at least one lip A.
    """
    held = {
        name[:-1]: np.isin(front, face_nodes(tets, faces)).sum()
        for name, faces in face_sets.items()
        if is_lip(name) and name.endswith("A")
    }
    crack = max(held, key=lambda name: held[name])
    return {name: faces for name, faces in face_sets.items() if is_lip(name) and name[:-1] == crack}


def crack_sets(lips: Sequence[tuple[np.ndarray, np.ndarray]]) -> dict[str, np.ndarray]:
    """Return face sets of the lips A and B (k, 2) of cracks; several cracks are numbered in their names."""
    if len(lips) == 1:
        return dict(zip(LIPS, lips[0]))
    return {
        f"CRACK_{number}_LIP_{side}": faces
        for number, pair in enumerate(lips, 1)
        for side, faces in zip("AB", pair)
    }


def node_sets_of(tets: np.ndarray, face_sets: Mapping, fronts: list) -> dict[str, np.ndarray]:
    """Return the node sets of the box, of the cracks' lips and of their ordered fronts.

    A plane's set holds the nodes of its faces; edges (XMIN_YMIN) and corners (XMIN_YMIN_ZMIN) are common to
    two and three planes. fronts: (ordered nodes, closed?). CRACK_FRONT holds all fronts one after the
    other; with several fronts each is also CRACK_FRONT_<k>, from 1; with several cracks CRACK_<k>_FRONT
    holds the fronts of one. Empty sets are left out.
    """
    sides = [name for name in face_sets if is_lip(name)]
    sets = {
        name: np.unique(face_nodes(tets, face_sets[name]))
        for name in (*BOX_PLANES, *sides)
        if name in face_sets
    }
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
    for name in sides:
        own = [nodes for nodes, _ in fronts if np.isin(nodes, sets[name]).all()]
        if name.endswith("A") and name not in LIPS and own:
            sets[name.replace("LIP_A", "FRONT")] = np.concatenate(own)
    return {name: nodes for name, nodes in sets.items() if len(nodes)}

"""Exodus II files (.e, .exo): one block per grain, node sets and side sets by their names."""

import os

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io.netcdf import Variable, write_netcdf
from craftmesh.types import TetMesh

Dimensions = dict[str, int | None]  # name -> length, None for the time steps
_NAME_LIMIT = 32
_ELEMENT = {4: "TETRA", 10: "TETRA10"}  # nodes in Abaqus' order
_SIDE = np.array([4, 1, 2, 3])  # Exodus' sides 124, 234, 143, 132 of S1..S4 = 123, 142, 243, 341


def write_exodus(path: str | os.PathLike, mesh: TetMesh) -> None:
    """Write an Exodus II file that keeps the grains and all sets, in NetCDF's 64-bit classic format.

    Element blocks GRAIN_<id> have the grain's id, and the element variable `grain` repeats it; elements
    are sorted by grain, and the element number map holds their numbers in the deck. Node sets keep
    their order; face sets become side sets. Empty sets are left out. Raises CraftmeshError for names
    of over 32 characters.
    """
    order = np.argsort(mesh.grain, kind="stable")
    grains, counts = np.unique(mesh.grain, return_counts=True)
    blocks = np.split(order, np.cumsum(counts)[:-1])
    dimensions: Dimensions = {"time_step": None, "len_string": 33, "len_line": 81}
    dimensions |= {"len_name": _NAME_LIMIT + 1, "num_dim": 3}
    dimensions |= {"num_nodes": len(mesh.points), "num_elem": len(order)}
    variables = [
        Variable(f"coord{axis}", ("num_nodes",), mesh.points[:, i]) for i, axis in enumerate("xyz")
    ]
    variables.append(_names("coor_names", "num_dim", list("xyz")))
    variables.append(Variable("elem_num_map", ("num_elem",), _integers(order + 1)))
    variables += _blocks(dimensions, mesh, grains, blocks)
    variables += _node_sets(dimensions, mesh)
    variables += _side_sets(dimensions, mesh, order)
    variables += _grain_variable(dimensions, grains, blocks)
    numbers: dict[str, np.number] = {"api_version": np.float32(5.1), "version": np.float32(5.1)}
    numbers |= {"floating_point_word_size": np.int32(8), "file_size": np.int32(1)}
    numbers |= {"maximum_name_length": np.int32(_NAME_LIMIT)}
    write_netcdf(path, dimensions, variables, numbers | {"title": "craftmesh"})


def _blocks(
    dimensions: Dimensions, mesh: TetMesh, grains: np.ndarray, blocks: list[np.ndarray]
) -> list[Variable]:
    dimensions["num_el_blk"] = len(grains)
    variables = _set_heads("eb", "num_el_blk", grains, [f"GRAIN_{grain}" for grain in grains.tolist()])
    element = {"elem_type": _ELEMENT[mesh.tets.shape[1]]}
    for k, rows in enumerate(blocks, 1):
        dimensions |= {f"num_el_in_blk{k}": len(rows), f"num_nod_per_el{k}": mesh.tets.shape[1]}
        shape = (f"num_el_in_blk{k}", f"num_nod_per_el{k}")
        variables.append(Variable(f"connect{k}", shape, _integers(mesh.tets[rows] + 1), element))
    return variables


def _node_sets(dimensions: Dimensions, mesh: TetMesh) -> list[Variable]:
    sets = {name: nodes for name, nodes in mesh.node_sets.items() if len(nodes)}
    if not sets:
        return []
    dimensions["num_node_sets"] = len(sets)
    variables = _set_heads("ns", "num_node_sets", np.arange(1, len(sets) + 1), list(sets))
    for k, nodes in enumerate(sets.values(), 1):
        dimensions[f"num_nod_ns{k}"] = len(nodes)
        variables.append(Variable(f"node_ns{k}", (f"num_nod_ns{k}",), _integers(nodes + 1)))
    return variables


def _side_sets(dimensions: Dimensions, mesh: TetMesh, order: np.ndarray) -> list[Variable]:
    sets = {name: faces for name, faces in mesh.face_sets.items() if len(faces)}
    if not sets:
        return []
    place = np.empty(len(order), np.int64)
    place[order] = np.arange(1, len(order) + 1)
    dimensions["num_side_sets"] = len(sets)
    variables = _set_heads("ss", "num_side_sets", np.arange(1, len(sets) + 1), list(sets))
    for k, faces in enumerate(sets.values(), 1):
        dimensions[f"num_side_ss{k}"] = len(faces)
        shape = (f"num_side_ss{k}",)
        variables.append(Variable(f"elem_ss{k}", shape, _integers(place[faces[:, 0]])))
        variables.append(Variable(f"side_ss{k}", shape, _integers(_SIDE[faces[:, 1]])))
    return variables


def _grain_variable(dimensions: Dimensions, grains: np.ndarray, blocks: list[np.ndarray]) -> list[Variable]:
    dimensions["num_elem_var"] = 1
    table = np.ones((len(grains), 1), np.int32)
    variables = [
        _names("name_elem_var", "num_elem_var", ["grain"]),
        Variable("elem_var_tab", ("num_el_blk", "num_elem_var"), table),
        Variable("time_whole", ("time_step",), np.zeros(1)),
    ]
    return variables + [
        Variable(
            f"vals_elem_var1eb{k}",
            ("time_step", f"num_el_in_blk{k}"),
            np.full((1, len(rows)), float(grain)),
        )
        for k, (grain, rows) in enumerate(zip(grains.tolist(), blocks), 1)
    ]


def _set_heads(kind: str, dimension: str, ids: np.ndarray, names: list[str]) -> list[Variable]:
    """Return status, ids and names of element blocks (eb), node sets (ns) or side sets (ss)."""
    return [
        Variable(f"{kind}_status", (dimension,), np.ones(len(ids), np.int32)),
        Variable(f"{kind}_prop1", (dimension,), _integers(ids), {"name": "ID"}),
        _names(f"{kind}_names", dimension, names),
    ]


def _names(variable: str, dimension: str, names: list[str]) -> Variable:
    long = [name for name in names if len(name) > _NAME_LIMIT or not name.isascii()]
    if long:
        raise CraftmeshError(
            f"set {long[0]}: Exodus names have up to {_NAME_LIMIT} ASCII characters; rename it"
        )
    width = _NAME_LIMIT + 1
    text = np.array([name.encode("ascii") for name in names], f"S{width}")
    return Variable(variable, (dimension, "len_name"), text.view("S1").reshape(-1, width))


def _integers(values: np.ndarray) -> np.ndarray:
    return np.asarray(values, np.int32)

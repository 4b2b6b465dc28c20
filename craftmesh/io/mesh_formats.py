"""Export formats of a mesh: VTK (.vtu), Gmsh (.msh, version 2.2), Exodus II (.e, .exo)."""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy

from craftmesh.atomic import atomic_path
from craftmesh.errors import CraftmeshError, existing_file
from craftmesh.extras import extra
from craftmesh.io.vtk import VTK_CELL_TYPE, element_masks, set_arrays
from craftmesh.io.vtk_xml import Dataset, write_dataset
from craftmesh.options import Options, option
from craftmesh.types import TetMesh

_CELLS = {4: ("tetra", "triangle"), 10: ("tetra10", "triangle6")}
# Shape given to scipy for every variable. scipy uses it only to find record variables and to sort. With one
# shape for all, variables keep their order, by which meshio names the sets of an Exodus file.
_ANY_LENGTH = (1,)
LARGEST = np.iinfo(np.int32).max // 4 * 4  # bytes of a variable: scipy stores its padded size as int32
_NAME_LIMIT = 32
_HEAD: dict[str, object] = {"api_version": np.float32(5.1), "version": np.float32(5.1)}
_HEAD |= {"floating_point_word_size": np.int32(8), "file_size": np.int32(1)}
_HEAD |= {"maximum_name_length": np.int32(_NAME_LIMIT), "title": "craftmesh"}
_ELEMENT = {4: "TETRA", 10: "TETRA10"}  # their node order is that of Abaqus
_SIDE = np.array([4, 1, 2, 3])  # Exodus side of Abaqus faces S1..S4 (123, 142, 243, 341)
VTK_FACE_TYPE = {4: 5, 10: 22}  # VTK_TRIANGLE, VTK_QUADRATIC_TRIANGLE


@dataclass(frozen=True)
class ExportOptions(Options):
    """Options of a mesh file for other programs."""

    opening: float = option(
        0.0,
        "gap between the crack faces in the file; 0: they coincide; 0.01 is for programs that merge "
        "coincident nodes, which would close the crack",
        "l_min",
        at_least=0,
        at_most=0.5,
    )
    ascii: bool = option(False, "write .msh as text, for programs that cannot read binary .msh")


def write_msh(path: str | os.PathLike, mesh: TetMesh, ascii: bool = False) -> None:
    """Write the mesh as Gmsh 2.2 with meshio; every set is a physical group with its own tag.

    Volumes are GRAIN_<id>, whose tag is the grain's id. Each face set is a group of triangles, with normals
    out of their elements, and each node set a group of points in its order. Tags of sets follow the largest
    grain id, face sets first, so all tags differ. A node set with a face set's name gets the suffix _NODES,
    because meshio has one list of group names for all dimensions. Elements come first, with the deck's
    numbers. Empty sets are left out, and also element data, because meshio 5.3 cannot read files with them.
    ascii: write text instead of binary. Raises CraftmeshError if the tags would exceed the format's limit.
    """
    with extra("formats"):
        from meshio import Mesh
        from meshio.gmsh import write

    solid, face = _CELLS[mesh.tets.shape[1]]
    cells, tags = [(solid, mesh.tets)], [mesh.grain]
    groups = {f"GRAIN_{grain}": np.array([grain, 3]) for grain in np.unique(mesh.grain).tolist()}
    parts = [(name, 2, face, mesh.outward_triangles(name)) for name in mesh.face_sets]
    for name, nodes in mesh.node_sets.items():
        parts.append((f"{name}_NODES" if name in mesh.face_sets else name, 0, "vertex", nodes[:, None]))
    largest = int(mesh.grain.max(initial=0))
    if largest + len(parts) > np.iinfo(np.int32).max:
        raise CraftmeshError(
            f"{path}: largest grain id {largest} plus {len(parts)} sets exceeds the largest tag of .msh, "
            "2147483647; renumber the grains, or export to another format"
        )
    for tag, (name, dimension, kind, nodes) in enumerate(parts, largest + 1):
        if len(nodes):
            cells.append((kind, nodes))
            tags.append(np.full(len(nodes), tag, np.int32))
            groups[name] = np.array([tag, dimension])
    data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
    whole = Mesh(mesh.points, cells, cell_data=data, field_data=groups)
    with atomic_path(path) as temporary:
        write(temporary, whole, "2.2", binary=not ascii)


@dataclass(frozen=True)
class Variable:
    """A NetCDF array with named dimensions, of integers (stored as int32), floats or single characters."""

    name: str
    dimensions: tuple[str, ...]
    values: np.ndarray
    attributes: Mapping[str, str] = field(default_factory=dict)


def write_netcdf(
    path: str | os.PathLike,
    dimensions: Mapping[str, int | None],
    variables: Sequence[Variable],
    attributes: Mapping[str, object],
) -> None:
    """Write a NetCDF file completely or not at all; the same input gives the same bytes.

    dimensions: name -> length > 0; None for the record dimension, which comes first and has one record.
    variables: written in this order, except that variables with the record dimension come last; it must be
    their first dimension. attributes: of the file, texts or numbers. Raises CraftmeshError, before it
    writes, for a variable over 2 GiB.
    """
    whole = {v.name: v.values.astype(np.int32, copy=False) for v in variables if v.values.dtype.kind == "i"}
    variables = [replace(v, values=whole.get(v.name, v.values)) for v in variables]
    for variable in variables:
        if variable.values.nbytes > LARGEST:
            raise CraftmeshError(
                f"{path}: {variable.name} needs {variable.values.nbytes} bytes, but scipy's NetCDF has at "
                f"most {LARGEST}; export to .vtu instead, or coarsen the mesh"
            )
    with atomic_path(path) as temporary, scipy.io.netcdf_file(temporary, "w", version=2) as file:
        for name, length in dimensions.items():
            file.createDimension(name, length)
        for name, value in attributes.items():
            setattr(file, name, value)
        for variable in variables:
            data = np.ascontiguousarray(variable.values, variable.values.dtype.newbyteorder(">"))
            is_record = dimensions[variable.dimensions[0]] is None
            file.variables[variable.name] = scipy.io.netcdf_variable(
                data,
                data.dtype.char,
                data.dtype.itemsize,
                (None,) if is_record else _ANY_LENGTH,
                variable.dimensions,
                dict(variable.attributes),
            )


def write_exodus(path: str | os.PathLike, mesh: TetMesh) -> None:
    """Write an Exodus II file with the grains and all sets, in NetCDF's 64-bit offset format.

    Each grain is an element block GRAIN_<id> with the grain's id, which the element variable `grain`
    repeats. Elements are sorted by grain; the element number map has their numbers in the deck. Node sets
    keep their order; face sets become side sets. Empty sets are left out. Raises CraftmeshError for names
    longer than 32 characters or not in ASCII, and for arrays over 2 GiB.
    """
    order = np.argsort(mesh.grain, kind="stable")
    place = np.argsort(order) + 1
    grains, counts = np.unique(mesh.grain, return_counts=True)
    blocks = dict(zip(grains.tolist(), np.split(order, np.cumsum(counts)[:-1])))
    nodes = {name: ids for name, ids in mesh.node_sets.items() if len(ids)}
    sides = {name: faces for name, faces in mesh.face_sets.items() if len(faces)}
    made = [Variable(f"coord{axis}", ("num_nodes",), mesh.points[:, i]) for i, axis in enumerate("xyz")]
    made += [
        _names("coor_names", "num_dim", list("xyz")),
        Variable("elem_num_map", ("num_elem",), order + 1),
    ]
    made += _set_heads("eb", "num_el_blk", grains, [f"GRAIN_{grain}" for grain in blocks])
    element = {"elem_type": _ELEMENT[mesh.tets.shape[1]]}
    for k, rows in enumerate(blocks.values(), 1):
        shape = (f"num_el_in_blk{k}", f"num_nod_per_el{k}")
        made.append(Variable(f"connect{k}", shape, mesh.tets[rows] + 1, element))
    made += _set_heads("ns", "num_node_sets", np.arange(1, len(nodes) + 1), list(nodes))
    made += [
        Variable(f"node_ns{k}", (f"num_nod_ns{k}",), own + 1) for k, own in enumerate(nodes.values(), 1)
    ]
    made += _set_heads("ss", "num_side_sets", np.arange(1, len(sides) + 1), list(sides))
    for k, (tets, faces) in enumerate((own.T for own in sides.values()), 1):
        made.append(Variable(f"elem_ss{k}", (f"num_side_ss{k}",), place[tets]))
        made.append(Variable(f"side_ss{k}", (f"num_side_ss{k}",), _SIDE[faces]))
    made.append(_names("name_elem_var", "num_elem_var", ["grain"]))
    made.append(Variable("elem_var_tab", ("num_el_blk", "num_elem_var"), np.ones((len(grains), 1), int)))
    made.append(Variable("time_whole", ("time_step",), np.zeros(1)))
    for k, (grain, rows) in enumerate(blocks.items(), 1):
        values = np.full((1, len(rows)), float(grain))
        made.append(Variable(f"vals_elem_var1eb{k}", ("time_step", f"num_el_in_blk{k}"), values))
    dimensions: dict[str, int | None] = {"time_step": None, "len_string": 33, "len_line": 81}
    for one in made:
        found = zip(one.dimensions, one.values.shape)
        dimensions |= {name: length for name, length in found if name not in dimensions}
    write_netcdf(path, dimensions, made, _HEAD)


def read_exodus(path: str | os.PathLike) -> TetMesh:
    """Return the mesh in a file of `write_exodus`: elements in the deck's order, and all sets.

    Raises CraftmeshError for any other file.
    """
    try:
        with scipy.io.netcdf_file(existing_file(path), "r", mmap=False) as file:
            found = {name: variable[:].copy() for name, variable in file.variables.items()}
        order, grains, local = found["elem_num_map"] - 1, found["eb_prop1"], np.argsort(_SIDE)
        tets = [found[f"connect{k}"] - 1 for k in range(1, len(grains) + 1)]
        back = np.argsort(order)
        node_sets = {name: found[f"node_ns{k}"] - 1 for k, name in _set_names(found, "ns")}
        face_sets = {
            name: np.column_stack([order[found[f"elem_ss{k}"] - 1], local[found[f"side_ss{k}"] - 1]])
            for k, name in _set_names(found, "ss")
        }
        points = np.column_stack([found[f"coord{axis}"] for axis in "xyz"])
        grain = np.repeat(grains, [len(rows) for rows in tets])
        return TetMesh(points, np.concatenate(tets)[back], grain[back], node_sets, face_sets)
    except (KeyError, ValueError, TypeError, IndexError, OSError) as error:
        raise CraftmeshError(
            f"{path}: not an Exodus file of craftmesh ({error}); write it with `craftmesh export`"
        ) from None


def _set_names(found: Mapping[str, np.ndarray], kind: str) -> Iterator[tuple[int, str]]:
    """Yield number, from 1, and name of a file's node sets or side sets.

    found: the file's variables by name; kind: "ns" for node sets, "ss" for side sets.
    """
    rows = found.get(f"{kind}_names", np.zeros((0, 1), "S1"))
    yield from enumerate((row.tobytes().rstrip(b"\0").decode("ascii") for row in rows), 1)


def _set_heads(kind: str, dimension: str, ids: np.ndarray, names: list[str]) -> list[Variable]:
    """Return status, ids and names of element blocks (eb), node sets (ns) or side sets (ss) as variables.

    dimension: name of the file's dimension that counts them. Returns [] if there are no names.
    """
    return [
        Variable(f"{kind}_status", (dimension,), np.ones(len(ids), int)),
        Variable(f"{kind}_prop1", (dimension,), ids, {"name": "ID"}),
        _names(f"{kind}_names", dimension, names),
    ][: 3 * bool(names)]


def _names(variable: str, dimension: str, names: list[str]) -> Variable:
    long = [name for name in names if len(name) > _NAME_LIMIT or not name.isascii()]
    if long:
        raise CraftmeshError(
            f"set {long[0]}: names in Exodus have at most {_NAME_LIMIT} ASCII characters; rename the set"
        )
    width = _NAME_LIMIT + 1
    text = np.array([name.encode("ascii") for name in names], f"S{width}")
    return Variable(variable, (dimension, "len_name"), text.view("S1").reshape(-1, width))


def write_vtu(path: str | os.PathLike, mesh: TetMesh, quaternions: np.ndarray | None = None) -> None:
    """Write a .vtu of the tetrahedra, then the triangles of each face set, normals out of their elements.

    Cell data: `grain` int32, 0 on triangles; `face_set` int32, 0 on tetrahedra and k on triangles of the
    k-th face set, counted from 1; element sets as in `write_tets`; if quaternions (m, 4) of the tetrahedra
    are given, `orientation`, NaN on triangles. Point data: an array per node set with its name, uint8, 1 on
    its nodes. Field data are the sets, as `write_tets` writes them, so `read_tets` also reads this file.
    """
    width, count = mesh.tets.shape[1], len(mesh.tets)
    triangles = [mesh.outward_triangles(name) for name in mesh.face_sets]
    numbers = np.repeat(np.arange(1, len(triangles) + 1), [len(rows) for rows in triangles])
    total = len(numbers)
    sizes = np.repeat([width, 3 if width == 4 else 6], [count, total])
    nodes = np.concatenate([mesh.tets.ravel(), *(rows.ravel() for rows in triangles)])
    every = np.arange(len(mesh.points))
    turned = {}
    if quaternions is not None:
        turned["orientation"] = np.concatenate([quaternions, np.full((total, 4), np.nan)])
    grid = Dataset(
        at_points={name: np.isin(every, own).astype(np.uint8) for name, own in mesh.node_sets.items()},
        at_cells={
            "grain": np.concatenate([mesh.grain, np.zeros(total, np.int32)]),
            "face_set": np.concatenate([np.zeros(count, np.int32), numbers.astype(np.int32)]),
            **element_masks(mesh, count + total),
            **turned,
        },
        others=set_arrays(mesh),
        points=mesh.points,
        cells={"Cells": (nodes, np.append(0, np.cumsum(sizes)))},
        types=np.repeat([VTK_CELL_TYPE[width], VTK_FACE_TYPE[width]], [count, total]).astype(np.uint8),
    )
    write_dataset(path, "UnstructuredGrid", grid)


# Functions that write a mesh to a path, by suffix without the dot.
MESH_FORMATS: dict[str, Callable[..., None]]
MESH_FORMATS = {"vtu": write_vtu, "msh": write_msh, "e": write_exodus, "exo": write_exodus}
GRAIN_TABLE = "csv"  # suffix of the table of grains, for formats that cannot store their properties
EXPORTS = (*MESH_FORMATS, GRAIN_TABLE)

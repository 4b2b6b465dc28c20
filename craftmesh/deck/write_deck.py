"""The input deck that Abaqus and CalculiX both read."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

import numpy as np

from craftmesh.atomic import atomic_path, atomic_paths
from craftmesh.deck.includes import include_line, mesh_file
from craftmesh.deck.inp_format import constant_lines, id_lines, integer_rows, name_lines, node_rows, number
from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.materials import Material, parse_materials
from craftmesh.mechanics.orientation import normalized, quaternion_to_matrix
from craftmesh.mesh.second_order import as_elements
from craftmesh.options import Options, option
from craftmesh.types import TetMesh

_HEADER = """\
*HEADING
craftmesh: {nodes} nodes, {elements} {element}, {grains} grains
** GRAIN_<id>: elements of grain id. XMIN..ZMAX, XMIN_YMIN.., XMIN_YMIN_ZMIN..: nodes of the box's planes,
** edges and corners; XMIN..ZMAX are surfaces too. CRACK_FRONT: front nodes in order. CRACK_LIP_A and
** CRACK_LIP_B: nodes and surfaces ahead of and behind the crack facets' normals. VOID_<k> and EXTERIOR:
** the other free surfaces.
** Numbers have at most 20 characters, the most that CalculiX reads; shorter ones keep every bit.
"""
_ORIENTATION_NOTE = """\
** ORI_<id> gives the sample components of the crystal's axes [100] and [010] in grain id: columns 1 and 2
** of the active rotation matrix R of its unit quaternion (w, x, y, z), v_sample = R v_crystal. Constants
** of materials, and stresses where the solver reports them locally, refer to the crystal's axes.
"""
_MESH_NOTE = "** Mesh of {model}: nodes, elements of the grains, node sets and surfaces; included by it.\n"
# Both solvers write these to their results files (.fil, .frd).
_OUTPUT = "*NODE FILE\nU, RF\n*EL FILE\nS, E\n"


@dataclass(frozen=True)
class DeckOptions(Options):
    """What the deck holds beside the mesh: element type, materials and one tension step."""

    element: str = option("C3D10", "element type", choices=("C3D4", "C3D10"))
    material: tuple[str, ...] = option(
        ("isotropic:70000,0.33",),
        "KIND:CONSTANTS for all phases or PHASE=KIND:CONSTANTS each; kinds and constants: isotropic E,nu; "
        "cubic c11,c12,c44; anisotropic 21 constants D1111,D1122,D2222,... in Abaqus' order",
    )
    load: str = option("strain", "what the step prescribes", choices=("strain", "stress", "none"))
    magnitude: float = option(1e-3, "the strain, or the stress in the materials' unit; tension is positive")
    axis: str = option("z", "axis of the tension", choices=("x", "y", "z"))
    sides: str = option(
        "free",
        "the minimum planes of the other two axes: free, with the body held against turning and sliding "
        "at two nodes, or on rollers (planes of symmetry, in which a crack is mirrored)",
        choices=("free", "rollers"),
    )
    quarter_points: bool = option(
        False, "move the mid nodes of C3D10 next to the crack front to a quarter of their edges"
    )
    includes: bool = option(
        False, "write nodes, elements and sets to MODEL_mesh.inp, which the deck MODEL.inp includes"
    )


def write_deck(
    target: str | os.PathLike | TextIO,
    mesh: TetMesh,
    options: DeckOptions = DeckOptions(),  # noqa: B008 (frozen)
    orientations: np.ndarray | None = None,
    phases: np.ndarray | None = None,
) -> dict:
    """Write the complete deck of `mesh` to a path (whole or not at all) or an open text stream.

    4-node meshes become 10-node ones for C3D10. orientations (g, 4): row = grain id, unit quaternion
    (w, x, y, z) of the active rotation from crystal to sample axes, NaN unknown; phases (g,): row =
    grain id. Grains of unknown orientation get sections without one. The same input gives the same
    bytes. With `includes` the mesh goes to `mesh_file(target)`, both files or neither. Return counts,
    those of the quarter points among them. Raises CraftmeshError when a cubic or anisotropic grain has
    no orientation, a phase has no material, the element type does not fit the mesh, the load has no
    face to act on, or a stream should have includes.
    """
    mesh, report = as_elements(mesh, options.element, options.quarter_points)
    grains = np.unique(mesh.grain)
    axes = _crystal_axes(grains, orientations)
    sections = list(_sections(grains, axes, parse_materials(options.material), phases))
    step = list(_step(mesh, options))
    header = _HEADER.format(**report, grains=len(grains)) + (_ORIENTATION_NOTE if axes else "")
    with _text_streams(target, options.includes) as (model, included):
        model.write(header)
        if included is not model:
            model.write(include_line(target))
            included.write(_MESH_NOTE.format(model=Path(target).name))
        included.writelines(_mesh_lines(mesh, grains, options.element))
        included.writelines(_set_lines(mesh))
        model.writelines(sections)
        model.writelines(step)
    return report | {"grains": len(grains)}


@contextmanager
def _text_streams(target, includes: bool) -> Iterator[tuple[TextIO, TextIO]]:
    """Yield the stream of the model and that of its mesh, one and the same without includes."""
    if hasattr(target, "write"):
        if includes:
            raise CraftmeshError("includes: a stream has no place for a second file; give a path")
        yield target, target
    elif not includes:
        with atomic_path(target) as path, _text(path) as stream:
            yield stream, stream
    else:
        include_line(target)
        with atomic_paths([target, mesh_file(target)]) as (path, beside):
            with _text(path) as model, _text(beside) as included:
                yield model, included


def _text(path: Path) -> TextIO:
    return open(path, "w", encoding="ascii", newline="\n")


def _mesh_lines(mesh: TetMesh, grains: np.ndarray, element: str) -> Iterator[str]:
    yield "*NODE, NSET=NALL\n"
    yield from node_rows(mesh.points)
    order = np.argsort(mesh.grain, kind="stable")
    ends = np.searchsorted(mesh.grain[order], grains, side="right")
    for grain, rows in zip(grains, np.split(order, ends[:-1])):
        yield f"*ELEMENT, TYPE={element}, ELSET=GRAIN_{grain}\n"
        yield from integer_rows(np.column_stack([rows, mesh.tets[rows]]) + 1)
    yield "*ELSET, ELSET=EALL\n"
    yield from name_lines(f"GRAIN_{grain}" for grain in grains)


def _set_lines(mesh: TetMesh) -> Iterator[str]:
    for name, nodes in mesh.node_sets.items():
        if len(nodes):
            yield f"*NSET, NSET={name}{', UNSORTED' if name.startswith('CRACK_FRONT') else ''}\n"
            yield from id_lines(nodes)
    for name, faces in mesh.face_sets.items():
        sides = [side for side in range(4) if (faces[:, 1] == side).any()]
        for side in sides:
            yield f"*ELSET, ELSET={name}_S{side + 1}\n"
            yield from id_lines(faces[faces[:, 1] == side, 0])
        if sides:
            yield f"*SURFACE, NAME={name}, TYPE=ELEMENT\n"
            yield from (f"{name}_S{side + 1}, S{side + 1}\n" for side in sides)


def _crystal_axes(grains, orientations) -> dict[int, np.ndarray]:
    """Return per grain of known orientation the sample components (6,) of its axes [100] and [010]."""
    if orientations is None:
        return {}
    grains = grains[grains < len(orientations)]
    matrices = quaternion_to_matrix(normalized(orientations[grains]))
    return {
        grain: matrix[:, :2].T.ravel()
        for grain, matrix in zip(grains.tolist(), matrices)
        if np.isfinite(matrix).all()
    }


def _sections(grains, axes, materials: dict[int | None, Material], phases) -> Iterator[str]:
    phase_of = {grain: _phase(grain, materials, phases) for grain in grains.tolist()}
    unoriented = [g for g in phase_of if g not in axes and materials[phase_of[g]].kind != "isotropic"]
    if unoriented:
        kind = materials[phase_of[unoriented[0]]].kind
        raise CraftmeshError(
            f"material: {kind} needs an orientation per grain, and {len(unoriented)} have none (the first: "
            f"{unoriented[0]}); give orientations with the microstructure, or an isotropic material"
        )
    for phase in sorted(set(phase_of.values()), key=lambda phase: phase or 0):
        material = materials[phase]
        yield f"*MATERIAL, NAME={_material_name(phase)}\n"
        if material.kind == "isotropic":
            yield "*ELASTIC\n"
            yield from constant_lines(list(material.constants))
        else:
            yield "*ELASTIC, TYPE=ANISOTROPIC\n"
            yield from constant_lines(material.upper_triangle())
    for grain, phase in phase_of.items():
        orientation = ""
        if grain in axes:
            yield f"*ORIENTATION, NAME=ORI_{grain}, SYSTEM=RECTANGULAR\n"
            yield from constant_lines(axes[grain].tolist())
            orientation = f", ORIENTATION=ORI_{grain}"
        yield f"*SOLID SECTION, ELSET=GRAIN_{grain}, MATERIAL={_material_name(phase)}{orientation}\n"


def _phase(grain: int, materials, phases) -> int | None:
    if None in materials:
        return None
    if phases is None:
        if len(materials) == 1:
            return next(iter(materials))
        raise CraftmeshError(
            f"material: {len(materials)} are given, but grains have no phase; give one for all"
        )
    phase = int(phases[grain]) if grain < len(phases) else 0
    if phase not in materials:
        raise CraftmeshError(f"material: grain {grain} has phase {phase}; give {phase}=KIND:CONSTANTS too")
    return phase


def _material_name(phase: int | None) -> str:
    return "MATERIAL" if phase is None else f"PHASE_{phase}"


def _step(mesh: TetMesh, options: DeckOptions) -> Iterator[str]:
    """Yield supports and one static step of tension; nothing where no load is asked for."""
    if options.load == "none":
        return
    axis = "xyz".index(options.axis)
    near, far = (f"{options.axis.upper()}{end}" for end in ("MIN", "MAX"))
    rollers = [f"{name}MIN" for name in "XYZ"] if options.sides == "rollers" else [near]
    for name in (*rollers, far):
        if not len(mesh.node_sets.get(name, ())):
            raise CraftmeshError(
                f"load: the mesh has no nodes on {name}; choose another axis, sides free, or load none"
            )
    yield "*BOUNDARY\n"
    yield from (f"{name}, {'XYZ'.index(name[0]) + 1}, {'XYZ'.index(name[0]) + 1}\n" for name in rollers)
    if options.sides == "free":
        yield from _held_nodes(mesh, axis, near)
    yield "*STEP\n*STATIC\n"
    if options.load == "strain":
        low, high = (mesh.points[mesh.node_sets[name][0], axis] for name in (near, far))
        pulled = number(float(options.magnitude * (high - low)))
        yield f"*BOUNDARY\n{far}, {axis + 1}, {axis + 1}, {pulled}\n"
    else:
        yield f"*DSLOAD\n{far}, P, {number(-float(options.magnitude))}\n"
    yield _OUTPUT + "*END STEP\n"


def _held_nodes(mesh: TetMesh, axis: int, near: str) -> Iterator[str]:
    """Hold one node of the plane `near` in its plane and the farthest from it against turning."""
    u, v = (other for other in range(3) if other != axis)
    nodes = mesh.node_sets[near]
    points = mesh.points[nodes]
    corner = np.lexsort((points[:, v], points[:, u]))[0]
    far = np.lexsort((np.abs(points[:, v] - points[corner, v]), -points[:, u]))[0]
    yield from (f"{nodes[corner] + 1}, {direction + 1}, {direction + 1}\n" for direction in (u, v))
    yield f"{nodes[far] + 1}, {v + 1}, {v + 1}\n"

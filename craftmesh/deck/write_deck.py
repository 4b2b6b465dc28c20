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
from craftmesh.deck.mesh_lines import mesh_lines, set_lines
from craftmesh.deck.section_lines import crystal_axes, section_lines
from craftmesh.deck.step_lines import step_lines
from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.load import tension
from craftmesh.mechanics.materials import parse_materials
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
    axes = crystal_axes(grains, orientations)
    sections = list(section_lines(grains, axes, parse_materials(options.material), phases))
    step = _step(mesh, options)
    header = _HEADER.format(**report, grains=len(grains)) + (_ORIENTATION_NOTE if axes else "")
    with _text_streams(target, options.includes) as (model, included):
        model.write(header)
        if options.includes and isinstance(target, (str, os.PathLike)):
            model.write(include_line(target))
            included.write(_MESH_NOTE.format(model=Path(target).name))
        included.writelines(mesh_lines(mesh, grains, options.element))
        included.writelines(set_lines(mesh))
        model.writelines(sections)
        model.writelines(step)
    return report | {"grains": len(grains)}


@contextmanager
def _text_streams(target: str | os.PathLike | TextIO, includes: bool) -> Iterator[tuple[TextIO, TextIO]]:
    """Yield the stream of the model and that of its mesh, one and the same without includes."""
    if not isinstance(target, (str, os.PathLike)):
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


def _step(mesh: TetMesh, options: DeckOptions) -> list[str]:
    """Return the lines of the load; none where none is asked for."""
    if options.load == "none":
        return []
    load = tension(
        mesh,
        "xyz".index(options.axis),
        options.magnitude,
        by_stress=options.load == "stress",
        rollers=options.sides == "rollers",
    )
    return list(step_lines(load))

"""The input deck that Abaqus and CalculiX both read."""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TextIO

import numpy as np

from craftmesh.atomic import atomic_path, atomic_paths
from craftmesh.deck.contact_lines import contact_lines, on_plates, plate_lines
from craftmesh.deck.includes import include_line, mesh_file
from craftmesh.deck.limits import check_writable
from craftmesh.deck.mesh_lines import layer_lines, mesh_lines, set_lines
from craftmesh.deck.options import MESH, PARTS, DeckOptions
from craftmesh.deck.parts import HEAD, in_parts
from craftmesh.deck.section_lines import AXES_TABLE, layer_section_lines, section_lines, user_section_lines
from craftmesh.deck.step_lines import face_lines, history_lines, step_lines, steps_of_cases
from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.cohesive import CohesiveLayers
from craftmesh.mechanics.history import held_step
from craftmesh.mechanics.model import ElasticModel, elastic_model
from craftmesh.mechanics.units import UnitsOptions
from craftmesh.mechanics.user_materials import UserMaterial, UserMaterials
from craftmesh.mesh.mesh_sets import NEW
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
_SCALE_NOTE = """\
** Lengths and displacements are {scale:g} times the model's (inp.scale). Stresses and moduli keep their
** unit, so that forces are {forces:g} times the model's.
"""
_STRAIN_NOTE = """\
** Expansions of materials are the eigenstrains of their grains: the temperature rises by 1, or at each
** node as inp.temperature says. Where an expansion has shears in the crystal's axes, ORI_<id> gives its
** principal axes in place of these, and constants of the material refer to them.
"""
_LAYER_NOTE = """\
** COH_<a>_<b>: cohesive elements on the boundary of grains a < b, nodes 1 to 3 on a, 4 to 6 on b; COH_ALL
** all. Their nodes are there once on each side: CRACK_FRONT has those in the grain of lowest id, and
** CRACK_FRONT_COPIES the others.
"""
_NEW_NOTE = "** NEW: elements that the mesh of the increment before does not have.\n"
_MESH_NOTE = "** Mesh of {model}: nodes, elements of the grains, node sets and surfaces; included by it.\n"
# Output requests of a history's steps, which have many increments.
_OUTPUT = "*NODE FILE, FREQUENCY={every}\nU, RF\n*EL FILE, FREQUENCY={every}\nS, E, ENER\n"


def write_deck(
    target: str | os.PathLike | TextIO,
    mesh: TetMesh,
    options: DeckOptions = DeckOptions(),  # noqa: B008 (frozen)
    orientations: np.ndarray | None = None,
    phases: np.ndarray | None = None,
    templates: Mapping[int | None, UserMaterial] | None = None,
) -> dict:
    """Write the complete deck of `mesh` to a path (whole or not at all) or an open text stream.

    4-node meshes become 10-node meshes for C3D10. orientations (g, 4): row = grain id, unit quaternion (w,
    x, y, z) of the active rotation from crystal to sample axes, NaN unknown; phases (g,): row = grain id.
    templates: the materials that user_material names, from `parse_templates`. Grains of unknown orientation
    get sections without an orientation. The same input gives the same bytes. With `includes` the mesh goes
    to `mesh_file(target)`; both files are written, or neither. Returns the report of `elastic_model`:
    element type, counts and notes. Raises CraftmeshError if a grain whose material is not isotropic has no
    orientation, a phase has no material, the element type does not fit the mesh, the load cannot act on the
    mesh, the solvers cannot read a set's name, or a stream should have includes.
    """
    model, report = elastic_model(mesh, options, orientations, phases)
    materials = None if templates is None else UserMaterials(templates, phases)
    write_model(target, model, options, materials)
    return report


def write_model(
    target: str | os.PathLike | TextIO,
    model: ElasticModel,
    options: DeckOptions = DeckOptions(),  # noqa: B008 (frozen)
    materials: UserMaterials | None = None,
    units: UnitsOptions = UnitsOptions(),  # noqa: B008 (frozen)
    traced: bool = False,
    layers: CohesiveLayers | None = None,
) -> None:
    """Write the complete deck of a model to a path or an open text stream, as `write_deck` does.

    materials: read from the template that options.user_material names; required if it is set. units: named
    in a comment. traced: each increment of a history prints the forces and displacements of faces, and
    fields are written only in a short additional step at the end, because CalculiX has one frequency for
    both. layers: the cohesive elements, on the model's mesh and in its unit; required if options.cohesive
    is set. With plates in options, the load acts by contact with them.
    """
    check_writable(model)
    if options.user_material and materials is None:
        raise CraftmeshError(
            f"user_material is {options.user_material!r}, but no file is read here; pass its materials"
        )
    if options.cohesive and layers is None:
        raise CraftmeshError("cohesive is set, but no layers are passed; pass the layers with their model")
    includes, layout = options.includes, options.style
    scale, model = model.scale, model.in_unit_of_deck()
    notes = _notes(model, layers, scale, layout)
    with _text_streams(target, includes) as (main, included):
        main.write(notes + _units_note(units) + (HEAD if layout == PARTS else ""))
        if includes and isinstance(target, (str, os.PathLike)):
            main.write(include_line(target))
            included.write(_MESH_NOTE.format(model=Path(target).name))
        included.writelines(mesh_lines(model.mesh, model.grains, model.element))
        if layers is not None:
            included.writelines(layer_lines(layers, len(model.mesh.tets) + 1))
        included.writelines(set_lines(model.mesh))
        if layout != MESH:
            lines = _model_lines(model, options, materials, traced, layers, scale)
            main.writelines(in_parts(lines) if layout == PARTS else lines)


def _notes(model: ElasticModel, layers: CohesiveLayers | None, scale: float, layout: str) -> str:
    """Return the heading, and comments on the deck's contents; layout: the option `style`."""
    nodes, elements, grains = map(len, (model.mesh.points, model.mesh.tets, model.grains))
    notes = _HEADER.format(nodes=nodes, elements=elements, element=model.element, grains=grains)
    notes += _NEW_NOTE if len(model.mesh.element_sets.get(NEW, ())) else ""
    if layout != MESH:
        notes += _ORIENTATION_NOTE if model.axes else ""
        notes += _STRAIN_NOTE if model.own_strain.any() else ""
    if layers is not None:
        notes += _LAYER_NOTE
    return notes + (_SCALE_NOTE.format(scale=scale, forces=scale**2) if scale != 1 else "")


def _model_lines(
    model: ElasticModel,
    options: DeckOptions,
    materials: UserMaterials | None,
    traced: bool,
    layers: CohesiveLayers | None,
    scale: float,
) -> Iterator[str]:
    """Yield the lines after the mesh: materials, axes and sections, contact and steps."""
    if model.element_axes is not None:
        yield f"*DISTRIBUTION TABLE, NAME={AXES_TABLE}\nCOORD3D, COORD3D\n"
    yield from section_lines(model) if materials is None else user_section_lines(model, materials)
    if layers is not None:
        yield from layer_section_lines(layers, scale)
    if options.lip_contact:
        yield from contact_lines(model)
    if options.has_plates and model.load is not None:
        yield from plate_lines(model.load, model.mesh)
        model = replace(model, load=on_plates(model.load))
    yield from _load_lines(model, options, materials, traced)


def _load_lines(
    model: ElasticModel, options: DeckOptions, materials: UserMaterials | None, traced: bool
) -> Iterator[str]:
    """Return the lines of the steps: of a history, else of each load case, else of the only load."""
    steps = [piece for step in options.history for piece in step.pieces()]
    if steps:
        user = None if materials is None else next(iter(materials.by_phase.values()))
        loads = model.loads(step.load for step in steps)
        asked = (_OUTPUT if user is None else user.output).replace("{every}", str(options.output_every))
        if options.restart_every:
            asked += f"*RESTART, WRITE, FREQUENCY={options.restart_every}\n"
        extras = [asked] * len(steps)
        if traced:
            faces, steps = face_lines(loads), [*steps, held_step(steps[-1])]
            extras = [faces] * len(extras) + [faces + asked]
        nlgeom = user is not None and user.nlgeom
        return history_lines(loads, steps, model.mesh, extras, nlgeom, model.temperature)
    if model.cases:
        return steps_of_cases(model.cases, model.mesh, model.temperature)
    if model.load is None:
        return iter(())
    return step_lines(model.load, model.mesh, model.temperature)


def _units_note(units: UnitsOptions) -> str:
    """Return the comment that names the model's units, in ASCII; micro becomes u."""
    named = ", ".join(f"{quantity} {unit}" for quantity, unit in units.by_quantity().items())
    text = named.translate({0xB5: "u", 0x3BC: "u"}).encode("ascii", "replace").decode("ascii")
    return f"** Units of the model: {text[:200]}\n" if named else ""


@contextmanager
def _text_streams(target: str | os.PathLike | TextIO, includes: bool) -> Iterator[tuple[TextIO, TextIO]]:
    """Yield the streams of the model and of its mesh; without includes they are the same."""
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

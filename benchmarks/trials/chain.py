"""The chain from voxels to the deck by the library's stages, and every stage's result for the checks."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from craftmesh.assembly.assemble import assemble
from craftmesh.cracks.in_boundaries import crack_in_boundaries
from craftmesh.cracks.options import IN_BOUNDARIES, CrackOptions
from craftmesh.cracks.prepare import prepare_crack
from craftmesh.cracks.series import GivenSurface, crack_of_increment
from craftmesh.deck.write_deck import DeckOptions, write_deck
from craftmesh.errors import CraftmeshError
from craftmesh.gradation.gradate import gradate
from craftmesh.insertion.insert import insert_crack
from craftmesh.io.vtk import write_crack, write_surface, write_tets
from craftmesh.mesh.shape_measures import flat_sentence, flat_tets
from craftmesh.mesh.tet_connectivity import severed_sentence
from craftmesh.remeshing.remesh import remesh
from craftmesh.renewal.options import RenewOptions
from craftmesh.renewal.renew import History, StageOptions, history_of, renew_mesh
from craftmesh.sizing.sources import Defects, sizing_around
from craftmesh.tetrahedra.volume import mesh_volume
from craftmesh.types import Crack, Surface, TetMesh
from craftmesh.voxels.islands import find_islands
from trials.drawing import Drawn


@dataclass
class Made:
    """What the chain made: surfaces, the sizing, the mesh, and the deck's path."""

    inserted: Surface | None = None
    gradated: Surface | None = None
    sizing: Any = None
    mesh: TetMesh | None = None
    deck: Path | None = None
    stage: str = "remesh"
    refusal: str | None = None
    warnings: tuple[str, ...] = ()
    history: History | None = None
    renewed: float | None = None


def run_chain(case: Drawn, folder: Path, crack: Crack | None = None, before: Made | None = None) -> Made:
    """Run all stages; the deck and each stage's file go to `folder`. A refusal ends it and is kept.

    crack: in place of the case's sheet, as it is; before: the increment whose mesh is renewed.
    """
    made = Made()
    try:
        _run(case, folder, made, crack, before)
    except CraftmeshError as error:
        made.refusal = " ".join(str(error).split())
    return made


def _run(case: Drawn, folder: Path, made: Made, crack: Crack | None, before: Made | None) -> None:
    surface, _ = remesh(case.voxels)
    made.stage = "crack"
    crack = crack or _crack(case, surface)
    write_crack(folder / "crack.vtp", crack)
    made.stage = "stitch"
    defects = Defects(crack)
    sizing = sizing_around(surface, defects, case.sizes)
    made.inserted, report = insert_crack(surface, crack, sizing)
    write_surface(folder / "surface.vtp", made.inserted)
    (folder / "stitch.json").write_text(json.dumps(report, default=_plain))
    made.stage = "gradate"
    made.sizing = sizing_around(made.inserted, defects, case.sizes)
    made.gradated, report = gradate(made.inserted, made.sizing, crack=crack)
    write_surface(folder / "gradated.vtp", made.gradated)
    (folder / "gradate.json").write_text(json.dumps(report, default=_plain))
    made.stage = "tetrahedralize"
    if before is None or before.mesh is None or before.history is None:
        mesh, report = _meshed(case, made, crack)
        made.history = history_of(mesh, sizing)
    else:
        options = StageOptions(RenewOptions("always"))
        islands = find_islands(case.voxels)
        found = renew_mesh(before.mesh, before.history, surface, crack, sizing, options, islands)
        mesh, report, made.history = found.mesh, found.report, found.history
        made.warnings += found.warnings
        made.renewed = report["renewed"]["share"]
    made.mesh = mesh
    write_tets(folder / "volume.vtu", mesh)
    (folder / "meshing.json").write_text(json.dumps(report, default=_plain))
    made.stage = "inp"
    deck = DeckOptions(element=case.element, quarter_points=case.quarter_points, load="none")
    write_deck(folder / "model.inp", mesh, deck, case.voxels.orientations, case.voxels.phases)
    made.deck = folder / "model.inp"


def _crack(case: Drawn, surface: Surface) -> Crack:
    """Return the crack that `craftmesh crack` makes of the case's sheet."""
    options = case.prescribed or CrackOptions(shape="surface")
    fronts = case.sheet.fronts if case.with_front else ()
    if options.shape == IN_BOUNDARIES:
        crack = crack_in_boundaries(surface, options, 0)
    else:
        given = None if case.prescribed else GivenSurface(case.sheet.points, case.sheet.triangles, fronts)
        crack = crack_of_increment(options, 0, case.voxels.box, given)
    of_facets = (0,) if options.shape == IN_BOUNDARIES else ()
    return prepare_crack([crack], case.voxels.box, float(case.sizes.l_min or 0), of_facets)


def _meshed(case: Drawn, made: Made, crack: Crack):
    """Return the assembled mesh and the report, with the whole model meshed anew where a grain fails."""
    volume, report = mesh_volume(made.gradated, made.sizing, islands=find_islands(case.voxels))
    made.warnings += volume.warnings
    made.warnings += tuple(f"meshing: {one.sentence()}" for one in volume.failures)
    mesh, assembled = assemble(volume.surface, volume.grain_tets, crack)
    made.warnings += tuple(filter(None, [flat_sentence(flat_tets(mesh)), severed_sentence(mesh)]))
    return mesh, report | assembled | {"meshing": volume.record}


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else str(value)


def write_inputs(case: Drawn, folder: Path) -> list[str]:
    """Write the case's inputs to `folder`; return the commands that redo it by hand."""
    from trimesh import Trimesh

    from craftmesh.io.front_csv import write_front
    from craftmesh.io.npz import write_labels
    from craftmesh.voxels.islands import islands_as_json

    folder.mkdir(parents=True, exist_ok=True)
    write_labels(folder / "labels.npz", case.voxels)
    (folder / "islands.json").write_text(json.dumps(islands_as_json(find_islands(case.voxels))))
    if case.prescribed:
        crack = _flags_of(case.prescribed)
    else:
        sheet = Trimesh(case.sheet.points, case.sheet.triangles, process=False)
        sheet.export(folder / "crack_in.stl")
        crack = "--shape surface --file crack_in.stl"
        if case.with_front:
            columns = dict(zip("xyz", np.concatenate(case.sheet.fronts).T))
            write_front(folder / "front_in.csv", columns)
            crack += " --front front_in.csv"
    wanted = ("l_min", "l0", "l_max", "r0", "r1", "gradation")
    given = {key: getattr(case.sizes, key) for key in wanted}
    sizes = " ".join(f"--{k.replace('_', '-')} {v!r}" for k, v in given.items() if v is not None)
    quarter = " --quarter-points" if case.quarter_points else ""
    front = f"--front crack.vtp {sizes}"
    lengths = f"--l-min {case.sizes.l_min!r} --l0 {case.sizes.l0!r}"
    deck = f"--element {case.element}{quarter}"
    return [
        f"cd {folder}",
        "craftmesh remesh labels.npz -o remeshed.vtp",
        f"craftmesh crack labels.npz {crack} {lengths} -o crack.vtp",
        f"craftmesh stitch remeshed.vtp --crack crack.vtp {sizes} -o surface.vtp",
        f"craftmesh gradate surface.vtp {front} -o gradated.vtp",
        f"craftmesh tetrahedralize gradated.vtp --islands islands.json {front} -o volume.vtu",
        f"craftmesh inp volume.vtu --microstructure labels.npz {deck} -o model.inp",
        "craftmesh check volume.vtu --labels labels.npz",
    ]


def _flags_of(options: CrackOptions) -> str:
    words = [f"--shape {options.shape}"]
    if options.boundaries:
        words.append("--surface remeshed.vtp --boundaries " + " ".join(options.boundaries))
    for name in ("centre", "normal", "axis"):
        words.append(f"--{name} " + " ".join(repr(float(x)) for x in getattr(options, name)))
    if options.semi_axes:
        words.append("--semi-axes " + " ".join(map(repr, options.semi_axes)))
    else:
        words.append(f"--radius {options.radius!r}")
    return " ".join(words)

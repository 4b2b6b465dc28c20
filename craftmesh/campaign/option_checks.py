"""Checks of a case's keys with the stages' own functions, so that errors appear before any job starts."""

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import replace
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from craftmesh.campaign.cases import SYNTHETIC, Case, check_exists
from craftmesh.campaign.configuration import fields_of
from craftmesh.campaign.paths import files_of
from craftmesh.cracks.options import CrackOptions, crack_files
from craftmesh.cracks.prescription import changing, check_crack, is_sized
from craftmesh.deck.options import DeckOptions
from craftmesh.errors import CraftmeshError
from craftmesh.growth.options import GrowthOptions, check_cycle, check_own
from craftmesh.growth.rates import laws_of
from craftmesh.io.user_material import read_template
from craftmesh.io.volume_format import AUTO, format_by_name
from craftmesh.mechanics.faces import parse_faces, rows_of
from craftmesh.mechanics.load import check_faces
from craftmesh.mechanics.materials import parse_materials, phases_of_grains
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.mechanics.user_materials import parse_templates
from craftmesh.sizing.sizing import SizingOptions, sizing_for
from craftmesh.solve.options import SolveOptions
from craftmesh.tetrahedra.meshers import TETWILD, check_mesher
from craftmesh.voxels.options import GenerateOptions

# Number of front edges per crack size below which a note is printed. With 5 edges K errs twice as much
# (docs/fracture.md).
EDGES = 10


def check_meaning(case: Case, config: Mapping[str, Any]) -> None:
    """Raise CraftmeshError, naming the key, for faults of a case that do not depend on its volume.

    config: the campaign's configuration. The message begins with the case's place (file, line, name),
    unless the faulty section is the same in `config`, so that all cases share the fault.
    """
    own = case.settings
    parts = [(section, own[section], config[section], check) for section, check in _CHECKS.items()]
    parts += [
        (f"cracks.{name}", own["cracks"][name], config["cracks"].get(name), _check_crack)
        for name in case.cracks
    ]
    for section, keys, common, check in parts:
        try:
            check(keys, case)
        except CraftmeshError as error:
            message = _keyed(section, str(error).removeprefix("crack.").removeprefix(f"{section}."), keys)
            raise CraftmeshError(message if keys == common else f"{case.place}: {message}") from None
    _check_increments(case)


def _keyed(section: str, message: str, keys: Collection[str]) -> str:
    """Return a stage's error message with `section.` in front of the key with which it begins.

    keys: the section's keys. A message that begins with no key gets `section: ` in front.
    """
    key = message.split()[0].rstrip(":,").partition("[")[0]
    return f"{section}.{message}" if key in keys else f"{section}: {message}"


def _check_files(section: str, keys: Mapping[str, Any]) -> None:
    for key, path in files_of(section, keys).items():
        check_exists(key, path)


def _check_generate(keys: Mapping[str, Any], case: Case) -> None:
    if case.microstructure == SYNTHETIC:
        GenerateOptions(**keys)
        _check_files("generate", keys)


def _check_import(keys: Mapping[str, Any], case: Case) -> None:
    if case.microstructure != SYNTHETIC and keys["format"] == AUTO:
        format_by_name(Path(case.microstructure))


def _check_sizing(keys: Mapping[str, Any], case: Case) -> None:
    _check_files("sizing", keys)
    sizing_of(case)


def sizing_of(case: Case) -> SizingOptions:
    """Return a case's checked edge lengths; l0, if not set, is the voxel edge by the configured spacing.

    l0 stays None if there is no spacing in the configuration.
    """
    section = "generate" if case.microstructure == SYNTHETIC else "import"
    spacing = case.settings[section]["spacing"]
    return checked_sizing(case.settings["sizing"], float(np.cbrt(prod(spacing))) if spacing else None)


def checked_sizing(keys: Mapping[str, Any], edge: float | None = None) -> SizingOptions:
    """Return the sizing options in `keys`; l0, if not set, is the voxel's `edge`.

    Raises CraftmeshError if lengths or radii contradict each other. If l0 is still unknown, because only
    the microstructure gives it, this is not checked.
    """
    options = SizingOptions(**keys)
    if options.l0 is None:
        options = replace(options, l0=edge)
    if options.l0 is not None:
        sizing_for(None, np.zeros((0, 3)), options)
    return options


def _check_tetrahedralize(keys: Mapping[str, Any], case: Case) -> None:
    check_mesher(keys["mesher"])
    if case.renews and keys["mesher"] == TETWILD:
        raise CraftmeshError(
            f"mesher is {TETWILD}, which meshes whole models, but renew.reuse is "
            f"{case.settings['renew']['reuse']}; set reuse to never, or use another mesher"
        )


def _check_inp(keys: Mapping[str, Any], case: Case) -> None:
    _check_files("inp", keys)
    options = DeckOptions(**keys)
    if options.user_material:
        parse_templates(read_template(options.user_material), f"user_material: {options.user_material}")
    try:
        materials = parse_materials(options.material)
        if case.microstructure == SYNTHETIC:  # its grains all have phase 1
            phases_of_grains(np.array([1]), materials, np.array([0, 1]))
    except CraftmeshError as error:
        raise CraftmeshError(f"material: {str(error).removeprefix('material: ')}") from None
    for name in options.cases or [""]:
        check_faces(rows_of(parse_faces(options.faces), name))


def _check_solve(keys: Mapping[str, Any], case: Case) -> None:
    deck = DeckOptions(**case.settings["inp"])
    SolveOptions(**keys).check_takes(bool(deck.cohesive), bool(deck.history), deck.has_plates)


def _check_grow(keys: Mapping[str, Any], case: Case) -> None:
    _check_files("grow", keys)
    options = GrowthOptions(**fields_of(GrowthOptions, keys))
    check_own(options)
    loads = ModelOptions(**fields_of(ModelOptions, case.settings["inp"])).combinations
    check_cycle(options, [one.name for one in loads])
    laws_of(options)


_CHECKS: dict[str, Callable[[Mapping[str, Any], Case], Any]] = {
    "generate": _check_generate,
    "import": _check_import,
    "sizing": _check_sizing,
    "tetrahedralize": _check_tetrahedralize,
    "inp": _check_inp,
    "solve": _check_solve,
    "grow": _check_grow,
}


def _check_crack(keys: Mapping[str, Any], case: Case) -> None:
    """Raise CraftmeshError if a crack lacks a key, an increment or a file, or if it shrinks.

    Only increments that the case prescribes are checked: the first one if the crack grows, else all.
    """
    options, prescribed = CrackOptions(**keys), 1 if case.grows else case.increments
    series = options.increments
    if series and len(series) < prescribed:
        raise CraftmeshError(
            f"increments lists {len(series)} increments, but case {case.name!r} of "
            f"{case.settings['cases']} needs {prescribed}; add the others, or lower the case's increments"
        )
    for increment in range(prescribed):
        check_crack(options, increment)
        for name, path in crack_files(options, increment).items():
            check_exists(name, path)
        if increment and is_sized(options):
            was, now = (changing(options, k) for k in (increment - 1, increment))
            if prod(now) < prod(was):
                raise CraftmeshError(f"increments: the crack shrinks from {was} to {now}; let it grow")


def _check_increments(case: Case) -> None:
    """Raise CraftmeshError if the case's growth, loads or increments do not fit its cracks.

    The crack must be able to grow as requested, loads on crack faces need a crack, and no prescribed
    increment may have the same cracks as the increment before.
    """
    model = ModelOptions(**fields_of(ModelOptions, case.settings["inp"]))
    if case.grows and model.element != "C3D10":
        raise CraftmeshError(
            f"{case.place}: inp.element is {model.element}, but the crack grows; set C3D10, whose "
            "displacements give stress intensity factors"
        )
    if case.grows and case.runs_history:
        raise CraftmeshError(
            f"{case.place}: solve.solver is {case.settings['solve']['solver']} with load steps, but growth "
            "needs K of a linear elastic field; set solver builtin, or growth prescribed"
        )
    if case.grows and not model.is_loaded:
        found = f"inp.load is {model.load}, inp.magnitude {model.magnitude:g}"
        raise CraftmeshError(
            f"{case.place}: {'inp.faces has no strain or stress but 0' if model.faces else found}, but the "
            "crack grows; set a strain, a stress or a lip_pressure"
        )
    if (model.loads_lips or model.residual_stress) and not case.cracks:
        raise CraftmeshError(
            f"{case.place}: inp.lip_pressure, lip_traction, lip_field or residual_stress load crack "
            f"faces, but case {case.name!r} has no crack; add a crack, or remove these keys for this case"
        )
    cracks = [CrackOptions(**case.settings["cracks"][name]) for name in case.cracks]
    for increment in range(1, 1 if case.grows else case.increments):
        before, now = ([changing(one, k) for one in cracks] for k in (increment - 1, increment))
        if before == now:
            raise CraftmeshError(
                f"{case.place}: increments is {case.increments}, but increment {increment} is the same as "
                f"{increment - 1}; set cracks.{case.cracks[0]}.growth or .increments, write `grow` in the "
                "column `growth` of the case table, or set fewer increments"
            )


def small_cracks(cases: Collection[Case]) -> Iterator[str]:
    """Yield a note, with case names, for each crack whose initial size is under EDGES edges of its front.

    Cases whose l_min and l0 are unknown before the import, and cracks from files, are not checked.
    """
    found: dict[tuple[str, float, float], list[str]] = {}
    for case in cases:
        options = sizing_of(case)
        if options.l_min is None and options.l0 is None:
            continue
        l_min = sizing_for(None, np.zeros((0, 3)), replace(options, l0=options.l0 or options.l_min)).l_min
        for name in case.cracks:
            crack = CrackOptions(**case.settings["cracks"][name])
            size = min(changing(crack, 0)) if is_sized(crack) else np.inf
            if size < EDGES * l_min * (1 - 1e-9):
                found.setdefault((name, size, l_min), []).append(case.name)
    for (name, size, l_min), names in found.items():
        others = f" and {len(names) - 1} more" * (len(names) > 1)
        yield (
            f"case {names[0]}{others}: crack {name} has size {size:g}, its front edges sizing.l_min "
            f"{l_min:g}; at least {EDGES} edges per size give stress intensities within one per cent"
        )

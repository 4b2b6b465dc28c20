"""Notes before any stage runs: materials for phases that no grain has, and phases without a material."""

import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from craftmesh.campaign.cases import SYNTHETIC, Case
from craftmesh.campaign.configuration import fields_of
from craftmesh.campaign.file_digest import KEPT, digest_of, keep
from craftmesh.errors import CraftmeshError, listed
from craftmesh.io.user_material import read_template
from craftmesh.mechanics.materials import parse_materials
from craftmesh.mechanics.user_materials import parse_templates


def phase_notes(cases: Iterable[Case]) -> Iterator[str]:
    """Yield a note, with case names, for each material of a phase that no grain has, and the reverse.

    The reverse is a phase of grains without a material.
    """
    found: dict[str, list[str]] = {}
    for case in cases:
        for fault in _faults(case):
            found.setdefault(fault, []).append(case.name)
    for fault, names in found.items():
        others = f" and {len(names) - 1} more" * (len(names) > 1)
        yield f"case {names[0]}{others}: {fault}"


def _faults(case: Case) -> Iterator[str]:
    keys = case.settings["inp"]
    given: dict[str, Mapping] = {"material": parse_materials(keys["material"])}
    if keys["user_material"]:
        given["user_material"] = parse_templates(read_template(keys["user_material"]), "user_material")
    given = {key: materials for key, materials in given.items() if None not in materials}
    there = _phases(case) if given else []
    for key, materials in given.items() if there else ():
        unused = [phase for phase in materials if phase not in there]
        if unused:
            yield f"inp.{key} names phase {listed(unused)}, but no grain has it; phases: {listed(there)}"
        lacking = [phase for phase in there if phase not in materials]
        if lacking:
            yield f"inp.{key} has no entry for phase {listed(lacking)}, which grains have; add one"


def _phases(case: Case) -> list[int]:
    """Return the phases (numbers) of a case's grains; [] if its file has no phases or cannot be read.

    The result is kept in a file, so that a microstructure is read again only when it changes.
    """
    if case.microstructure == SYNTHETIC:
        return [1]
    from craftmesh.voxels.reading import ReadOptions, read_voxels  # here because its import is slow

    keys = fields_of(ReadOptions, case.settings["import"])
    content = digest_of(os.path.abspath(case.microstructure), keys["format"])
    name = hashlib.sha256(f"{content} {json.dumps(keys)}".encode()).hexdigest()[:32]
    entry = KEPT.with_name("phases") / f"{name}.json"
    try:
        return json.loads(entry.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        pass
    try:
        phases = read_voxels(case.microstructure, ReadOptions(**keys)).voxels.phases
    except (CraftmeshError, OSError):  # the stage `import` reports the error
        return []
    found = [] if phases is None else np.unique(phases[phases > 0]).tolist()
    keep(entry, found)
    return found

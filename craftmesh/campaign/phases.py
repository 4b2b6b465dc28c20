"""Notes before a stage runs: materials of phases that no grain has, and phases without a material."""

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
    """Yield notes, each with its cases: materials of phases that no grain has, and phases without one."""
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
            yield f"inp.{key} has phase {listed(unused)}, which no grain has; phases there: {listed(there)}"
        lacking = [phase for phase in there if phase not in materials]
        if lacking:
            yield f"inp.{key} has none for phase {listed(lacking)}, which grains have; give one for it too"


def _phases(case: Case) -> list[int]:
    """Return the phases of a case's grains, none where its file has none or is refused.

    A file is read once while it stays as it is.
    """
    if case.microstructure == SYNTHETIC:
        return [1]
    from craftmesh.voxels.reading import ReadOptions, read_voxels  # takes long to import

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
    except (CraftmeshError, OSError):  # its stage says what is wrong with it
        return []
    found = [] if phases is None else np.unique(phases[phases > 0]).tolist()
    keep(entry, found)
    return found

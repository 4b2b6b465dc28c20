"""Digests of the files that stages read: a rule with a digest as a parameter runs again when it changes.

File times are not enough: an older file may replace a newer one, and a header file may refer to a data
file. So the rules mark the files themselves as ancient, and Snakemake ignores their times.
"""

import hashlib
import os
import shlex
from collections.abc import Mapping
from pathlib import Path

from craftmesh.campaign.campaign import Campaign
from craftmesh.campaign.cases import SYNTHETIC
from craftmesh.campaign.configuration import fields_of
from craftmesh.campaign.file_digest import digest_of
from craftmesh.errors import listed
from craftmesh.io.user_material import PRESETS, template_file
from craftmesh.io.volume_format import AUTO
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.solve.options import BUILTIN, EXTERNAL, FIELD, waited_for

_SECTIONS: dict[str, tuple[str, ...]]
_SECTIONS = {"generate": ("generate",), "size": ("sizing",), "inp": ("inp",), "solve": ("inp",)}
_SECTIONS |= {"fracture": ("inp", "grow")}


def given_files(campaign: Campaign, stage: str, case: str, inc: str = "") -> list[str]:
    """Return the user's files that a stage (a module of `commands`) reads for a case and increment.

    Some may be files that the workflow makes, such as a crack that grew in another case.
    """
    one = campaign.cases[case]
    if stage == "import_":
        return [] if one.microstructure == SYNTHETIC else [one.microstructure]
    if stage == "crack":
        return [] if one.grows and int(inc) else campaign.crack_files(case, inc)
    return [path for section in _SECTIONS[stage] for path in campaign.section_files(section, case)]


def is_made(campaign: Campaign, path: str) -> bool:
    """Return True if a file lies in a case's results folder, for example a crack that the workflow grew."""
    folder, *rest = Path(os.path.relpath(path, campaign.results)).parts
    return bool(rest) and folder in campaign.cases


def content(campaign: Campaign, stage: str, case: str, inc: str = "") -> str | None:
    """Return a text with one digest of all files that a stage reads; None if it reads none.

    The files are the user's files outside the results, templates of the package, and fields and programs of
    external solvers. Files that the workflow makes are left out, because Snakemake follows them.
    """
    settings = campaign.cases[case].settings
    kind = settings["import"]["format"] if stage == "import_" else AUTO
    given = given_files(campaign, stage, case, inc)
    files = [path for path in given if not is_made(campaign, path)]
    if stage == "solve":
        files += _of_solver(settings, Path(campaign.results, case, inc))
    template = settings["inp"]["user_material"] if stage in ("inp", "solve") else ""
    read = [*files, str(template_file(template))] if template in PRESETS else files
    if not read:
        return None
    digests = [digest_of(os.path.abspath(path), kind) for path in read]
    total = hashlib.sha256("\n".join(digests).encode()).hexdigest()[:16]
    return f"content {total} of {listed(files or [template])}"


def _of_solver(settings: Mapping, folder: Path) -> list[str]:
    """Return paths of files that a case's solver needs, besides the mesh.

    These are the displacement files of solver external, else files with absolute paths in the solver's
    commands. settings: the case's configuration; folder: of the increment, for displacement files.
    """
    keys = settings["solve"]
    if keys["solver"] == EXTERNAL:
        cases = ModelOptions(**fields_of(ModelOptions, settings["inp"])).cases
        return list(map(str, waited_for(folder / FIELD, cases)))
    calls = () if keys["solver"] == BUILTIN else keys["command"]
    words = [word.rpartition("=")[2] for call in calls for word in shlex.split(call)]
    return [word for word in words if os.path.isabs(word) and os.path.isfile(word)]

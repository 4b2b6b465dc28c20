"""Digests of the files that stages read: a rule that has them as a parameter runs again when they change.

Times of files say less: an older file may take the place of a newer one, and data lie behind headers. To
Snakemake the files themselves are ancient.
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
    """Return the files of the user that a stage (a module of `commands`) of an increment reads."""
    one = campaign.cases[case]
    if stage == "import_":
        return [] if one.microstructure == SYNTHETIC else [one.microstructure]
    if stage == "crack":
        return [] if one.grows and int(inc) else campaign.crack_files(case, inc)
    return [path for section in _SECTIONS[stage] for path in campaign.section_files(section, case)]


def is_made(campaign: Campaign, path: str) -> bool:
    """Return whether a file lies in the folder of a case, as a crack that the workflow grew."""
    folder, *rest = Path(os.path.relpath(path, campaign.results)).parts
    return bool(rest) and folder in campaign.cases


def content(campaign: Campaign, stage: str, case: str, inc: str = "") -> str | None:
    """Return a text with one digest of all files that a stage reads; None where a stage reads no file.

    The files are the user's, templates of the package, and the fields and programs of other solvers.
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
    """Return the fields that a solver waits for, and the files that its calls name by absolute paths."""
    keys = settings["solve"]
    if keys["solver"] == EXTERNAL:
        cases = ModelOptions(**fields_of(ModelOptions, settings["inp"])).cases
        return list(map(str, waited_for(folder / FIELD, cases)))
    calls = () if keys["solver"] == BUILTIN else keys["command"]
    words = [word.rpartition("=")[2] for call in calls for word in shlex.split(call)]
    return [word for word in words if os.path.isabs(word) and os.path.isfile(word)]

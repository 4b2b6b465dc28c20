"""Digests of the files that stages read: a rule that has them as a parameter runs again when they change.

Times of files say less: an older file may take the place of a newer one, and data lie behind headers. To
Snakemake the files themselves are ancient.
"""

import hashlib
import json
import os
import shlex
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from craftmesh.atomic import atomic_path
from craftmesh.campaign.campaign import Campaign
from craftmesh.campaign.cases import SYNTHETIC
from craftmesh.campaign.configuration import fields_of
from craftmesh.errors import CraftmeshError, listed
from craftmesh.io.behind import files_behind
from craftmesh.io.user_material import PRESETS, template_file
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.solve.options import BUILTIN, EXTERNAL, FIELD, waited_for

KEPT = Path(".snakemake", "craftmesh", "content")  # digests that are known, in the folder of the run
AUTO = "auto"
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


def content(campaign: Campaign, stage: str, case: str, inc: str = "") -> str | None:
    """Return what is in the files that a stage reads, as one text; None for a stage that reads none.

    These are the user's files, templates of the package, and the fields and programs of other solvers.
    """
    settings = campaign.cases[case].settings
    kind = settings["import"]["format"] if stage == "import_" else AUTO
    files = given_files(campaign, stage, case, inc)
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


@cache
def digest_of(path: str, kind: str = AUTO) -> str:
    """Return the digest of a file, or of a folder of slices, and of all that its reader opens behind it.

    It is found once in a process, and kept below KEPT for the next one while no file changes its size, its
    times or its inode. Where the reader would refuse the file, the reason is part of the digest.
    """
    entry = KEPT / f"{hashlib.sha256(f'{kind} {path}'.encode()).hexdigest()[:32]}.json"
    known = _known(entry)
    if known:
        return known
    fault, files = "", [Path(path)]
    try:
        files += files_behind(files[0], kind)
    except (CraftmeshError, OSError) as error:
        fault = str(error)
    before = {str(file): _stamp(file) for file in files}
    total = hashlib.sha256(fault.encode())
    for file in files:
        if file.is_file():
            with open(file, "rb") as stream:
                total.update(hashlib.file_digest(stream, "sha256").digest())
        elif not file.is_dir():
            total.update(b"missing")
    found = total.hexdigest()
    if not fault and before == {str(file): _stamp(file) for file in files}:
        _keep(entry, {"files": before, "digest": found})
    return found


def _stamp(path: Path) -> list[int]:
    """Return what differs after any change of a file, whatever time it is given; empty without the file."""
    if not path.exists():
        return []
    found = path.stat()
    return [found.st_size, found.st_mtime_ns, found.st_ctime_ns, found.st_ino]


def _known(entry: Path) -> str:
    """Return the digest that is kept; empty where files have changed, or may have in the same tick."""
    try:
        known = json.loads(entry.read_text(encoding="utf-8"))
        written = int(entry.stat().st_mtime)  # whole seconds: some file systems know no less
        stamps = {name: _stamp(Path(name)) for name in known["files"]}
        is_settled = all(stamp[2] // 10**9 < written for stamp in stamps.values())
        return known["digest"] if is_settled and stamps == known["files"] else ""
    except (OSError, ValueError, KeyError, IndexError, TypeError):
        return ""


def _keep(entry: Path, known: Mapping) -> None:
    try:
        entry.parent.mkdir(parents=True, exist_ok=True)
        with atomic_path(entry) as temporary:
            temporary.write_text(json.dumps(known), encoding="utf-8")
    except (OSError, CraftmeshError):
        return  # a folder that cannot be written to: the digest is found anew each time

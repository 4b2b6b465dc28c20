"""Digests of files and of the further files that their readers open, kept for later processes."""

import hashlib
import json
from functools import cache
from pathlib import Path
from typing import Any

from craftmesh.atomic import atomic_path
from craftmesh.errors import CraftmeshError
from craftmesh.io.behind import files_behind
from craftmesh.io.volume_format import AUTO

KEPT = Path(".snakemake", "craftmesh", "content")  # folder of kept digests, in the run's working folder


@cache
def digest_of(path: str, kind: str = AUTO) -> str:
    """Return the digest of a file, or a folder of slices, and of the further files that its reader opens.

    kind: the file's format, or AUTO. The digest is computed once in a process. It is kept in the folder
    KEPT for later processes, and is valid while no file changes size, time or inode. If the reader would
    reject the file, the reason is part of the digest, which is then not kept.
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
        keep(entry, {"files": before, "digest": found})
    return found


def _stamp(path: Path) -> list[int]:
    """Return a file's size, times (ns) and inode, one of which changes with the file; [] if missing."""
    if not path.exists():
        return []
    found = path.stat()
    return [found.st_size, found.st_mtime_ns, found.st_ctime_ns, found.st_ino]


def _known(entry: Path) -> str:
    """Return the digest kept in `entry`; "" if files have changed since then, or in the same second."""
    try:
        known = json.loads(entry.read_text(encoding="utf-8"))
        written = int(entry.stat().st_mtime)  # whole seconds: some file systems store no fractions
        stamps = {name: _stamp(Path(name)) for name in known["files"]}
        is_settled = all(stamp[2] // 10**9 < written for stamp in stamps.values())
        return known["digest"] if is_settled and stamps == known["files"] else ""
    except (OSError, ValueError, KeyError, IndexError, TypeError):
        return ""


def keep(entry: Path, known: Any) -> None:
    """Write `known` as JSON to `entry`; do nothing if that fails, because it can be computed again."""
    try:
        entry.parent.mkdir(parents=True, exist_ok=True)
        with atomic_path(entry) as temporary:
            temporary.write_text(json.dumps(known), encoding="utf-8")
    except (OSError, CraftmeshError):
        return

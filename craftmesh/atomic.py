"""Output files that are written completely or not at all."""

import errno
import os
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from uuid import uuid4

from craftmesh.errors import CraftmeshError

UNFINISHED = ".tmp-"  # how names of files begin that are not complete yet


@contextmanager
def atomic_path(path: str | os.PathLike) -> Iterator[Path]:
    """Yield a temporary file name in the folder of `path`; the file is renamed to `path` after the block.

    The name keeps the suffix of `path`; missing folders are created. If the block raises, the temporary
    file is removed, and an older file at `path` stays unchanged. Raises CraftmeshError if the system cannot
    write (no space, no permission).
    """
    with atomic_paths([path]) as (temporary,):
        yield temporary


@contextmanager
def atomic_folder(path: str | os.PathLike) -> Iterator[Path]:
    """Yield a new folder that is renamed to `path` after the block and replaces an older folder there.

    If the block raises, the new folder is removed, and an older one at `path` stays unchanged. Raises
    CraftmeshError if the system cannot write.
    """
    target = Path(path)
    temporary = _beside(target)
    old = temporary.with_name(f"{temporary.name}-old")
    try:
        with _told(target):
            target.parent.mkdir(parents=True, exist_ok=True)
            temporary.mkdir()
            yield temporary
            if target.exists():
                os.replace(target, old)
            os.replace(temporary, target)
    finally:
        for left in (temporary, old):
            shutil.rmtree(left, ignore_errors=True)


@contextmanager
def atomic_paths(paths: Sequence[str | os.PathLike]) -> Iterator[list[Path]]:
    """Yield a temporary file name for each of `paths`; all are renamed after the block, none if it raises.

    Folders and errors as in `atomic_path`. The first path is the file that refers to the others. An older
    one is removed before the others change, and the new one is renamed last. So whoever finds this file
    also finds the other files of the same run.
    """
    targets = [Path(path) for path in paths]
    temporaries = [_beside(target) for target in targets]
    try:
        with _told(targets[0]):
            for target in targets:
                target.parent.mkdir(parents=True, exist_ok=True)
            yield temporaries
            if any(target.is_dir() for target in targets):
                raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
            if len(targets) > 1:
                targets[0].unlink(missing_ok=True)
            for temporary, target in reversed(list(zip(temporaries, targets))):
                os.replace(temporary, target)
    finally:
        for temporary in temporaries:
            with suppress(OSError):
                temporary.unlink()


def _beside(target: Path) -> Path:
    """Return an unused name in the folder of `target`, with the same suffix."""
    return target.with_name(f"{UNFINISHED}{uuid4().hex[:12]}-{target.name}")


@contextmanager
def _told(target: Path) -> Iterator[None]:
    """Turn an OSError in the block into a CraftmeshError that names `target`."""
    try:
        yield
    except OSError as error:
        is_file = isinstance(error, FileExistsError | NotADirectoryError)
        reason = f"{error.filename} is not a folder" if is_file else error.strerror or str(error)
        raise CraftmeshError(
            f"{target}: cannot be written ({reason}); check the folder and the disk space"
        ) from error

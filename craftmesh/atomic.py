"""Output files that appear whole or not at all."""

import errno
import os
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from uuid import uuid4

from craftmesh.errors import CraftmeshError


@contextmanager
def atomic_path(path: str | os.PathLike) -> Iterator[Path]:
    """Yield a temporary name beside `path` that becomes `path` when the block ends well.

    The name keeps the suffix of `path`; missing folders are made. When the block fails, the temporary
    file is removed and a file that was at `path` before stays as it was. Raises CraftmeshError where
    the system refuses to write (no space, no permission).
    """
    with atomic_paths([path]) as (temporary,):
        yield temporary


@contextmanager
def atomic_folder(path: str | os.PathLike) -> Iterator[Path]:
    """Yield a new folder that becomes `path`, in place of an old one there, when the block ends well.

    When the block fails, the new folder is removed and what was at `path` before stays as it was. Raises
    CraftmeshError where the system refuses to write.
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
    """Yield a temporary name for each of `paths`; all become theirs when the block ends well, or none does.

    As `atomic_path`. The first path is the one that refers to the others: it goes before they change and
    comes last, so it is never there beside files of another time.
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
    """Return a name beside `target` that nothing else has, with the same suffix."""
    return target.with_name(f".tmp-{uuid4().hex[:12]}-{target.name}")


@contextmanager
def _told(target: Path) -> Iterator[None]:
    """Raise CraftmeshError that names `target` where the system refuses to write."""
    try:
        yield
    except OSError as error:
        is_file = isinstance(error, FileExistsError | NotADirectoryError)
        reason = f"{error.filename} is no folder" if is_file else error.strerror or str(error)
        raise CraftmeshError(
            f"{target}: cannot be written ({reason}); check the folder and its space"
        ) from error

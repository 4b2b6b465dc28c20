"""Output files that appear whole or not at all."""

import os
from collections.abc import Iterator
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
    path = Path(path)
    temporary = path.with_name(f".tmp-{uuid4().hex[:12]}-{path.name}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield temporary
        os.replace(temporary, path)
    except OSError as error:
        reason = error.strerror or str(error)
        raise CraftmeshError(
            f"{path}: cannot be written ({reason}); check the folder and its space"
        ) from error
    finally:
        with suppress(OSError):
            temporary.unlink()

"""Compiled modules (.pyc) that are written whole or not at all."""

import os
from contextlib import suppress
from functools import cache
from importlib.machinery import SourceFileLoader
from typing import Any


@cache
def keep_bytecode_whole() -> None:
    """Make Python remove each .pyc that a full disk truncates.

    Python before 3.12.8 and 3.13.1 keeps the truncated file; later imports of the module then fail with
    "marshal data too short". Source: issue 126606 of CPython.
    """
    write: Any = SourceFileLoader.set_data

    def set_data(loader: SourceFileLoader, path: str, data: bytes, **mode: int) -> None:
        write(loader, path, data, **mode)
        with suppress(OSError):
            if os.path.getsize(path) != len(data):
                os.unlink(path)

    setattr(SourceFileLoader, "set_data", set_data)  # noqa: B010 - mypy refuses to assign to a method

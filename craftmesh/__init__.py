"""craftmesh: from labelled microstructures and cracks to gradated tetrahedral finite-element models.

The public names stand in `__init__.pyi`, where type checkers find them too; each is imported at its first
use, so that `import craftmesh` takes no time.
"""

import importlib
import re
from pathlib import Path
from typing import Any

from craftmesh.bytecode import keep_bytecode_whole

_STUB = Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")
# public name -> module that defines it
_EXPORTS = {name: module for module, name in re.findall(r"^from (\S+) import (\w+) as \2$", _STUB, re.M)}
__all__ = list(_EXPORTS)

keep_bytecode_whole()


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return importlib.import_module("importlib.metadata").version(
            __name__
        )  # 0.1 s, only where asked for
    if name not in _EXPORTS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(_EXPORTS[name]), name)


def __dir__() -> list[str]:
    return sorted({*_EXPORTS, "__version__", *(name for name in globals() if name.startswith("__"))})

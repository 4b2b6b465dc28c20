"""craftmesh: from labelled microstructures and cracks to gradated tetrahedral finite-element models."""

import importlib
import sys
import types
from typing import Any

_EXPORTS = {
    "gradate": "craftmesh.gradate",
    "GradateOptions": "craftmesh.gradate",
    "Sizing": "craftmesh.sizing.sizing",
    "SizingOptions": "craftmesh.sizing.sizing",
    "sizing_for": "craftmesh.sizing.sizing",
    "Surface": "craftmesh.types",
}
__all__ = list(_EXPORTS)


class _Package(types.ModuleType):
    """A package whose function `gradate` is not overwritten by its submodule of the same name.

    Importing craftmesh.gradate sets that attribute of the package to the module; here it stays the
    function, and `import craftmesh.gradate as module` is not the way to reach the module:
    `from craftmesh.gradate import ...` is.
    """

    def __setattr__(self, name: str, value: Any) -> None:
        if name == "gradate" and isinstance(value, types.ModuleType):
            value = vars(value).get("gradate", value)
        super().__setattr__(name, value)


def __getattr__(name: str) -> Any:
    if name not in _EXPORTS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(_EXPORTS[name]), name)


sys.modules[__name__].__class__ = _Package

"""craftmesh: from labelled microstructures and cracks to gradated tetrahedral finite-element models."""

import importlib
from typing import Any

from craftmesh.bytecode import keep_bytecode_whole

_EXPORTS = {
    "gradate": "craftmesh.gradation.gradate",
    "GradateOptions": "craftmesh.gradation.gradate",
    "Sizing": "craftmesh.sizing.sizing",
    "SizingOptions": "craftmesh.sizing.sizing",
    "sizing_for": "craftmesh.sizing.sizing",
    "open_crack": "craftmesh.assembly.open_crack",
    "insert_crack": "craftmesh.insertion.insert",
    "InsertOptions": "craftmesh.insertion.options",
    "crack_from_triangles": "craftmesh.cracks.triangulated",
    "CraftmeshError": "craftmesh.errors",
    "check_surface": "craftmesh.surface.check_surface",
    "Crack": "craftmesh.types",
    "Surface": "craftmesh.types",
    "TetMesh": "craftmesh.types",
}
__all__ = list(_EXPORTS)

keep_bytecode_whole()


def __getattr__(name: str) -> Any:
    if name not in _EXPORTS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(_EXPORTS[name]), name)

"""The schema of the workflow's configuration, made from the stages' option classes.

`python -m craftmesh.campaign.config_schema FILE` writes it anew; a test compares it with
schemas/config.schema.yaml beside this module, so an option has one definition for the library, the
command line and the configuration.
"""

import dataclasses
import importlib
import sys
import types
import typing
from pathlib import Path
from typing import Any

SECTIONS = {
    "generate": ("the synthetic microstructure", ["voxels.generate.GenerateOptions"]),
    "import": (
        "reading and cleaning of microstructure files",
        ["voxels.reading.ReadOptions", "voxels.clean.CleanOptions"],
    ),
    "remesh": ("surface from labelled voxels", ["remeshing.remesh.RemeshOptions"]),
    "sizing": ("the sizing function, Eq. 2-3", ["sizing.sizing.SizingOptions"]),
    "stitch": (
        "joining of surfaces and insertion of the crack",
        ["stitching.stitch.StitchOptions", "insertion.options.InsertOptions"],
    ),
    "gradate": ("gradation of the surface", ["gradation.gradate.GradateOptions"]),
    "tetrahedralize": ("tetrahedra in the grains", ["tetrahedra.options.TetrahedralizeOptions"]),
    "inp": ("the input deck", ["deck.write_deck.DeckOptions"]),
}
EXPORTS = ("vtu", "msh", "e", "exo")
CRACK = "cracks.options.CrackOptions"
KINDS = {float: "number", int: "integer", bool: "boolean", str: "string"}


def config_schema() -> dict:
    """Return the JSON schema of the configuration: paths, stage sections and named cracks."""
    properties: dict[str, Any] = {
        "cases": {
            "type": "string",
            "description": "tab-separated sheet: case, microstructure, crack, increments",
        },
        "results": _text("results", "folder of all that the campaign writes"),
        "data": _text(".", "folder from which the sheet's microstructures are named"),
        "chunks": {
            "type": "integer",
            "minimum": 1,
            "maximum": 64,
            "default": 2,
            "description": "jobs that share the tetrahedra of an increment",
        },
        "exports": {
            "type": "array",
            "items": {"enum": list(EXPORTS)},
            "default": [],
            "description": "formats besides the deck in which the mesh is written, as model.FORMAT",
        },
        "cracks": {
            "type": "object",
            "default": {},
            "description": "cracks by the names that the sheet uses",
            "additionalProperties": _section("one crack", [CRACK]),
        },
    }
    for name, (about, classes) in SECTIONS.items():
        properties[name] = _section(about, classes) | {"default": {}}
    _refine_sizing(properties["sizing"])
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "description": "configuration of a craftmesh campaign; made by craftmesh.campaign.config_schema",
        "type": "object",
        "additionalProperties": False,
        "required": ["cases", "sizing"],
        "properties": properties,
    }


def _text(default: str, about: str) -> dict:
    return {"type": "string", "minLength": 1, "default": default, "description": about}


def _section(about: str, classes: list[str]) -> dict:
    properties = {}
    for path in classes:
        module, name = path.rsplit(".", 1)
        cls = getattr(importlib.import_module(f"craftmesh.{module}"), name)
        hints = typing.get_type_hints(cls)
        for field in dataclasses.fields(cls):
            properties[field.name] = _property(field, hints[field.name])
    return {"type": "object", "description": about, "additionalProperties": False, "properties": properties}


def _property(field: dataclasses.Field, hint: Any) -> dict:
    parts = typing.get_args(hint) if isinstance(hint, types.UnionType) else (hint,)
    kinds = [_kind(part) for part in parts if part is not type(None)]
    if len(parts) > len(kinds):
        kinds.append("null")
    unit = field.metadata.get("unit")
    about = field.metadata.get("help", "") + (f" [{unit}]" if unit else "")
    made: dict[str, Any] = {"type": kinds[0] if len(kinds) == 1 else kinds, "description": about}
    if field.default is not dataclasses.MISSING:
        made["default"] = list(field.default) if isinstance(field.default, tuple) else field.default
    if isinstance(field.default, tuple) and field.default and Ellipsis not in typing.get_args(hint):
        made |= {"minItems": len(field.default), "maxItems": len(field.default)}
    if field.metadata.get("choices"):
        made["enum"] = [*field.metadata["choices"], *([None] if "null" in kinds else [])]
    return made


def _kind(hint: Any) -> str:
    return "array" if tuple in (hint, typing.get_origin(hint)) else KINDS[hint]


def _refine_sizing(section: dict) -> None:
    """Make l0 a number that has to be given, for a default would differ from stage to stage."""
    for name, made in section["properties"].items():
        made |= {"minimum": 0} if name in ("r0", "r1") else {"exclusiveMinimum": 0}
    l0 = section["properties"]["l0"]
    del l0["default"]
    l0 |= {"type": "number", "description": "original edge length, about the voxel's (Eq. 3) [length]"}
    about = "refine around the enclosed voids as well"
    section["properties"]["around_voids"] = {"type": "boolean", "default": False, "description": about}
    section["required"] = ["l0"]


def main(path: Path) -> None:
    import yaml

    text = yaml.safe_dump(config_schema(), sort_keys=False, width=100)
    path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))

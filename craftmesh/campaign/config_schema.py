"""The schema of the workflow's configuration, made from the stages' option classes.

`python -m craftmesh.campaign.config_schema FILE` writes it anew; a test compares it with
schemas/config.schema.yaml beside this module, so an option has one definition for the library, the
command line and the configuration.
"""

import dataclasses
import importlib
import sys
from collections.abc import Mapping
from pathlib import Path
from types import NoneType
from typing import Any

from craftmesh.io.mesh_formats import EXPORTS
from craftmesh.options import BOUNDS, alternatives, hints_of, items_of

SECTIONS = {
    "generate": ("the synthetic microstructure", ["voxels.options.GenerateOptions"]),
    "import": (
        "reading and cleaning of microstructure files",
        ["voxels.reading.ReadOptions", "voxels.options.CleanOptions"],
    ),
    "units": ("names of your units: labels, nothing is converted", ["mechanics.units.UnitsOptions"]),
    "remesh": ("surface from labelled voxels", ["remeshing.remesh.RemeshOptions"]),
    "sizing": ("the sizing function, Eq. 2-3", ["sizing.sizing.SizingOptions"]),
    "stitch": (
        "joining of surfaces and insertion of the crack",
        ["stitching.stitch.StitchOptions", "insertion.options.InsertOptions"],
    ),
    "gradate": ("gradation of the surface", ["gradation.gradate.GradateOptions"]),
    "tetrahedralize": ("tetrahedra in the grains", ["tetrahedra.options.TetrahedralizeOptions"]),
    "inp": ("the input deck", ["mechanics.model_options.ModelOptions", "deck.options.DeckOptions"]),
    "export": ("the mesh for other programs", ["io.mesh_formats.ExportOptions"]),
    "solve": ("the field of displacements", ["solve.options.SolveOptions"]),
    "fracture": ("K, J and T along the crack's fronts", ["fracture.options.FractureOptions"]),
    "grow": (
        "which way and how far cracks grow",
        [
            "growth.options.GrowthOptions",
            "growth.options.SmoothingOptions",
            "growth.options.CorrectionOptions",
        ],
    ),
    "node": ("a node of the cluster, where jobs are not run here", ["campaign.effort.NodeOptions"]),
    "report": ("the page of all campaigns", ["report.sweeps.ReportOptions"]),
}
CRACK = "cracks.options.CrackOptions"
KINDS = {float: "number", int: "integer", bool: "boolean", str: "string", NoneType: "null"}


def config_schema() -> dict:
    """Return the JSON schema of the configuration: paths, stage sections and named cracks."""
    properties: dict[str, Any] = {
        "cases": {
            "type": "string",
            "description": "tab-separated sheet: case, microstructure, crack, increments, growth, keys",
        },
        "sweep": {
            "type": "object",
            "default": {},
            "description": "values by section.key; each case of the sheet becomes one for each of them",
            "additionalProperties": {"type": "array", "minItems": 1},
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
        "warm": {
            "type": "boolean",
            "default": True,
            "description": "run stages here in children of one process that has all loaded",
        },
        "exports": {
            "type": "array",
            "items": {"enum": [*EXPORTS, *(f".{kind}" for kind in EXPORTS)]},
            "default": [],
            "description": "formats besides the deck in which the mesh is written, as model.FORMAT; "
            "with msh comes csv, the table of its grains",
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
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "description": "configuration of a craftmesh campaign; made by craftmesh.campaign.config_schema",
        "type": "object",
        "additionalProperties": False,
        "required": ["cases"],
        "properties": properties,
    }


def _text(default: str, about: str) -> dict:
    return {"type": "string", "minLength": 1, "default": default, "description": about}


def _section(about: str, classes: list[str]) -> dict:
    properties = {}
    for path in classes:
        cls = option_class(path)
        for field in dataclasses.fields(cls):
            properties[field.name] = _property(field, hints_of(cls)[field.name])
    return {"type": "object", "description": about, "additionalProperties": False, "properties": properties}


def option_class(path: str) -> Any:
    """Return the option class of a dotted name within the package."""
    module, name = path.rsplit(".", 1)
    return getattr(importlib.import_module(f"craftmesh.{module}"), name)


def _property(field: dataclasses.Field, hint: Any) -> dict:
    unit = field.metadata.get("unit")
    made = _values(hint, field.metadata)
    made["description"] = field.metadata.get("help", "") + (f" [{unit}]" if unit else "")
    if field.default is not dataclasses.MISSING:
        made["default"] = list(field.default) if isinstance(field.default, tuple) else field.default
    if field.metadata.get("choices"):
        made["enum"] = list(field.metadata["choices"]) + [None] * ("null" in made["type"])
    return made


def _values(hint: Any, metadata: Mapping[str, Any]) -> dict:
    """Return the schema of the values that `options.is_admitted` admits, choices left aside."""
    parts = alternatives(hint)
    kinds = list(dict.fromkeys("array" if items_of(part) else KINDS[part] for part in parts))
    made: dict[str, Any] = {"type": kinds[0] if len(kinds) == 1 else kinds}
    if {"number", "integer"} & set(kinds):
        bounds = metadata.get("bounds", {})
        made |= {BOUNDS[name].schema_key: limit for name, limit in bounds.items()}
    for kind, count in filter(None, map(items_of, parts)):
        made["items"] = _values(kind, metadata)
        made |= {} if count is None else {"minItems": count, "maxItems": count}
    return made


def main(path: Path) -> None:
    import yaml

    text = yaml.safe_dump(config_schema(), sort_keys=False, width=100)
    path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))

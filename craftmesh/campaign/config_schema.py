"""The JSON schema of the workflow's configuration, made from the stages' option classes.

`python -m craftmesh.campaign.config_schema FILE` writes the schema. A test compares it with
schemas/config.schema.yaml next to this module. So an option has one definition for the library, the
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
from craftmesh.options import BOUNDS, alternatives, choices_of, hints_of, items_of

SECTIONS = {
    "generate": ("the synthetic microstructure", ["voxels.options.GenerateOptions"]),
    "import": (
        "how microstructure files are read and cleaned",
        ["voxels.reading.ReadOptions", "voxels.options.CleanOptions"],
    ),
    "units": ("names of your units for reports; no conversion", ["mechanics.units.UnitsOptions"]),
    "remesh": ("surface from labelled voxels", ["remeshing.remesh.RemeshOptions"]),
    "sizing": ("the sizing function, Eq. 2-3", ["sizing.sizing.SizingOptions"]),
    "stitch": (
        "joining of grain surfaces and insertion of the crack",
        ["stitching.stitch.StitchOptions", "insertion.options.InsertOptions"],
    ),
    "gradate": (
        "gradation of the surface mesh to the target edge lengths",
        ["gradation.gradate.GradateOptions"],
    ),
    "tetrahedralize": ("tetrahedral meshes of the grains", ["tetrahedra.options.TetrahedralizeOptions"]),
    "renew": ("meshes that keep what a growing crack leaves unchanged", ["renewal.options.RenewOptions"]),
    "inp": ("the input deck", ["mechanics.model_options.ModelOptions", "deck.options.DeckOptions"]),
    "export": ("the mesh for other programs", ["io.mesh_formats.ExportOptions"]),
    "solve": ("the displacement field and its solver", ["solve.options.SolveOptions"]),
    "fracture": ("K, J and T along the crack fronts", ["fracture.options.FractureOptions"]),
    "grow": (
        "direction and extension of crack growth",
        [
            "growth.options.GrowthOptions",
            "growth.options.SmoothingOptions",
            "growth.options.CorrectionOptions",
        ],
    ),
    "node": ("size of a cluster node, if jobs run on a cluster", ["campaign.job_resources.NodeOptions"]),
    "report": ("the HTML report of all campaigns", ["report.sweeps.ReportOptions"]),
}
CRACK = "cracks.options.CrackOptions"
KINDS = {float: "number", int: "integer", bool: "boolean", str: "string", NoneType: "null"}


def config_schema() -> dict:
    """Return the JSON schema of the configuration: paths, sections of the stages, and named cracks."""
    properties: dict[str, Any] = {
        "cases": {
            "type": "string",
            "description": "tab-separated case table: case, microstructure, crack, increments, growth, key",
        },
        "sweep": {
            "type": "object",
            "default": {},
            "description": "lists of values by section.key; each row of the case table runs with each one",
            "additionalProperties": {"type": "array", "minItems": 1},
        },
        "results": _text("results", "folder to which the campaign writes everything"),
        "data": _text(".", "folder to which microstructure paths in the case table are relative"),
        "chunks": {
            "type": "integer",
            "minimum": 1,
            "maximum": 64,
            "default": 2,
            "description": "number of jobs that mesh the grains of an increment in parallel",
        },
        "warm": {
            "type": "boolean",
            "default": True,
            "description": "on this machine, run stages as forks of one process with everything loaded",
        },
        "exports": {
            "type": "array",
            "items": {"enum": [*EXPORTS, *(f".{kind}" for kind in EXPORTS)]},
            "default": [],
            "description": "further formats of the mesh, written as model.FORMAT; "
            "msh adds a csv table of the grains",
        },
        "cracks": {
            "type": "object",
            "default": {},
            "description": "cracks by the names that the case table uses",
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
    """Return the option class with the dotted name `path`, relative to the package."""
    module, name = path.rsplit(".", 1)
    return getattr(importlib.import_module(f"craftmesh.{module}"), name)


def _property(field: dataclasses.Field, hint: Any) -> dict:
    unit = field.metadata.get("unit")
    made = _values(hint, field.metadata)
    made["description"] = field.metadata.get("help", "") + (f" [{unit}]" if unit else "")
    if field.default is not dataclasses.MISSING:
        made["default"] = list(field.default) if isinstance(field.default, tuple) else field.default
    if choices := choices_of(hint):
        made["enum"] = [*choices, *[None] * ("null" in made["type"])]
    return made


def _values(hint: Any, metadata: Mapping[str, Any]) -> dict:
    """Return the schema of the values that `options.is_admitted` accepts for `hint`, without choices."""
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

"""Templates of user materials: YAML files, those of the package by name."""

from pathlib import Path
from typing import Any

from craftmesh.errors import CraftmeshError, named
from craftmesh.io.yaml_file import read_yaml

FOLDER = Path(__file__).with_name("user_materials")
PRESETS = tuple(sorted(path.stem for path in FOLDER.glob("*.yaml")))


def template_file(name: str) -> Path:
    """Return the file of a template: one of PRESETS, or the path of another."""
    return FOLDER / f"{name}.yaml" if name in PRESETS else Path(name)


def read_template(name: str) -> Any:
    """Return what a template holds: one of PRESETS, or a YAML file.

    Raises CraftmeshError for a file that is missing or no YAML.
    """
    path = template_file(name)
    if not path.exists():
        raise CraftmeshError(
            f"user_material: {name} cannot be read; expected {', '.join(PRESETS)}, or a file .yaml"
        )
    with named("user_material"):
        return read_yaml(path)

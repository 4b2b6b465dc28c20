"""Templates of user materials: YAML files, those of the package by name."""

from pathlib import Path
from typing import Any

from craftmesh.errors import CraftmeshError, existing_file

FOLDER = Path(__file__).with_name("user_materials")
PRESETS = tuple(sorted(path.stem for path in FOLDER.glob("*.yaml")))


def template_file(name: str) -> Path:
    """Return the file of a template: one of PRESETS, or the path of another."""
    return FOLDER / f"{name}.yaml" if name in PRESETS else Path(name)


def read_template(name: str) -> Any:
    """Return what a template holds: one of PRESETS, or a YAML file.

    Raises CraftmeshError for a file that is missing or no YAML.
    """
    import yaml

    path = template_file(name)
    if path.exists():
        existing_file(path, "expected a file .yaml")
    try:
        return yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError):
        raise CraftmeshError(
            f"user_material: {name} cannot be read; expected {', '.join(PRESETS)}, or a file .yaml"
        ) from None
    except yaml.YAMLError as error:
        line = " ".join(str(error).split())
        raise CraftmeshError(f"user_material: {name} is no YAML ({line}); see docs/umat.md") from None

"""Templates of user materials: YAML files of the user, or built-in ones by name."""

from pathlib import Path
from typing import Any

from craftmesh.errors import CraftmeshError, named
from craftmesh.io.yaml_file import read_yaml

FOLDER = Path(__file__).with_name("user_materials")
PRESETS = tuple(sorted(path.stem for path in FOLDER.glob("*.yaml")))


def template_file(name: str) -> Path:
    """Return the file of a template; name: one of PRESETS, or the path of a YAML file."""
    return FOLDER / f"{name}.yaml" if name in PRESETS else Path(name)


def read_template(name: str) -> Any:
    """Return the content of a template; name: one of PRESETS, or the path of a YAML file.

    The content is not checked here. Raises CraftmeshError if the file is missing or not YAML.
    """
    path = template_file(name)
    if not path.exists():
        raise CraftmeshError(
            f"user_material: {name} does not exist; give {', '.join(PRESETS)}, or a .yaml file"
        )
    with named("user_material"):
        return read_yaml(path)

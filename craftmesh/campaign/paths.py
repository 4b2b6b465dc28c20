"""Paths that a campaign names: expanded, and refused where its workflow cannot take them."""

import os
import re
import unicodedata
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from craftmesh.errors import CraftmeshError
from craftmesh.io.user_material import PRESETS

# the keys of sections that name files which their stages read
SECTION_FILES = {
    "generate": ("voids_from",),
    "sizing": ("points", "field"),
    "inp": ("lip_field", "eigenstrain_file", "user_material"),
    "grow": ("slip_table",),
}
CRACK_FILES = ("file", "front")
_VARIABLE = re.compile(r"\$(?:([A-Za-z_]\w*)|\{(\w+)\})", re.ASCII)
_ADDRESS = re.compile(r"[A-Za-z][\w+.-]*://")
_FILLED_IN = re.compile(r"[{}]|<[^<>]*>")  # Snakemake puts wildcards and path variables in their place
_BREAKING = {"Cc", "Cs", "Zl", "Zp"}  # Unicode's control characters, undecoded bytes and ends of lines


def written_path(key: str, text: str) -> str:
    """Return the path of a folder that a campaign writes, `~`, `$NAME` and `${NAME}` expanded.

    Raises CraftmeshError, beginning with `key`, for a variable that is not set, a path that cannot stand in
    a Snakemake workflow or a sheet, and one that lies in a file.
    """
    path = _for_commands(key, _expanded(key, text))
    above = next(part for part in (Path(path), *Path(path).absolute().parents) if os.path.lexists(part))
    if not above.is_dir():
        raise CraftmeshError(f"{key} is {text!r}, but {above} is no folder; expected one, or a new name")
    return os.path.abspath(path) if path == "." else path  # Snakemake warns of ./ before each file


def read_path(key: str, text: str, folder: Path = Path()) -> str:
    """Return the path of what a campaign reads, named from `folder`; as `written_path`.

    What is there by that very name is meant, whatever `~` and `$` stand for.
    """
    is_there = os.path.lexists(folder / text)
    return _for_commands(key, str(folder / (text if is_there else _expanded(key, text))))


def refuse_unexpanded(words: Sequence[str], given: str, results: str) -> None:
    """Raise CraftmeshError for a target in results `given` as `~/x`, which Snakemake does not expand."""
    word = next((word for word in words if word.startswith(f"{given}/")), None)
    if word and given != results:
        named = results + word.removeprefix(given)
        raise CraftmeshError(f"the target {word!r} is not expanded by Snakemake; name it {named!r}")


def files_of(section: str, keys: Mapping[str, Any]) -> dict[str, str]:
    """Return the files that a section's keys name, by key; templates of the package are none."""
    found = {key: keys.get(key) for key in SECTION_FILES[section]}
    return {key: path for key, path in found.items() if path and path not in PRESETS}


def with_paths(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return settings with the paths of the files of sections and cracks as `read_path` has them."""
    sections = {
        name: settings[name] | _read(files_of(name, settings[name]), name) for name in SECTION_FILES
    }
    cracks = {
        name: keys | _read({key: keys[key] for key in CRACK_FILES if keys.get(key)}, f"cracks.{name}")
        for name, keys in settings["cracks"].items()
    }
    for name, keys in cracks.items():
        if keys.get("increments"):
            place = f"cracks.{name}.increments"
            keys["increments"] = [
                read_path(place, given) if isinstance(given, str) else given for given in keys["increments"]
            ]
    return {**settings, **sections, "cracks": cracks}


def _read(files: Mapping[str, str], name: str) -> dict[str, str]:
    return {key: read_path(f"{name}.{key}", path) for key, path in files.items()}


def _expanded(key: str, text: str) -> str:
    """Return `text` with its variables' values and the home folder; `$` before anything else stays."""

    def value(found: re.Match) -> str:
        name = found[1] or found[2]
        if name not in os.environ:
            raise CraftmeshError(
                f"{key} is {text!r}, and the variable {name} is not set; set it, or write the path out"
            )
        return os.environ[name]

    path = os.path.expanduser(_VARIABLE.sub(value, text))
    if path.startswith("~"):
        raise CraftmeshError(
            f"{key} is {text!r}, and {path.split('/')[0]} is no user's home folder; expected ~/ or ./~"
        )
    return path


def _for_commands(key: str, path: str) -> str:
    """Return `path` as rules and commands take it: absolute where it would be a flag."""
    found = _FILLED_IN.search(path)
    if found:
        raise CraftmeshError(
            f"{key} is {path!r}; expected a path without braces or <name>: Snakemake fills them"
        )
    if _ADDRESS.match(path):
        raise CraftmeshError(f"{key} is {path!r}; expected a path in the file system, not an address")
    if any(unicodedata.category(letter) in _BREAKING for letter in path):
        raise CraftmeshError(f"{key} is {path!r}; expected a path of one line of text, in UTF-8")
    path = str(Path(path))
    return os.path.abspath(path) if path.startswith("-") else path

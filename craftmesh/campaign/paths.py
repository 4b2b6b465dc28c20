"""Paths that a campaign names: expand `~` and variables, and reject paths that the workflow cannot use."""

import os
import re
import unicodedata
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from craftmesh.errors import CraftmeshError
from craftmesh.io.user_material import PRESETS

# Keys, by section, whose values are names of files that a stage reads.
SECTION_FILES = {
    "generate": ("voids_from",),
    "sizing": ("points", "field"),
    "inp": ("lip_field", "residual_stress", "eigenstrain_file", "temperature", "user_material"),
    "grow": ("slip_table", "block_table"),
}
CRACK_FILES = ("file", "front")
_VARIABLE = re.compile(r"\$(?:([A-Za-z_]\w*)|\{(\w+)\})", re.ASCII)
_ADDRESS = re.compile(r"[A-Za-z][\w+.-]*://")
_FILLED_IN = re.compile(r"[{}]|<[^<>]*>")  # Snakemake's wildcards and path variables
_BREAKING = {"Cc", "Cs", "Zl", "Zp"}  # Unicode categories: control characters, undecoded bytes, line ends


def written_path(key: str, text: str) -> str:
    """Return `text`, the path of a folder to write, with `~`, `$NAME` and `${NAME}` expanded.

    Raises CraftmeshError, beginning with `key`, for a variable that is not set, a path that Snakemake or
    the case table cannot contain, and a path that is a file or below a file.
    """
    path = _for_commands(key, _expanded(key, text))
    above = next(part for part in (Path(path), *Path(path).absolute().parents) if os.path.lexists(part))
    if not above.is_dir():
        raise CraftmeshError(f"{key}: cannot create {text!r}, {above} is not a folder; choose another path")
    return os.path.abspath(path) if path == "." else path  # Snakemake warns if file names begin with ./


def read_path(key: str, text: str, folder: Path = Path()) -> str:
    """Return the path of a file to read, `text` relative to `folder`, with `~` and variables expanded.

    If a file with the unexpanded name exists, `~` and `$` are part of the name. Whether the file exists is
    not checked. Raises CraftmeshError, beginning with `key`, for a variable that is not set and for letters
    that Snakemake or the case table cannot contain.
    """
    is_there = os.path.lexists(folder / text)
    return _for_commands(key, str(folder / (text if is_there else _expanded(key, text))))


def refuse_unexpanded(words: Sequence[str], given: str, results: str) -> None:
    """Raise CraftmeshError for a target in the results folder that is written with `~` or variables.

    Snakemake does not expand these. words: the words of the command line; given: the key `results` as the
    configuration has it; results: its expanded path.
    """
    word = next((word for word in words if word.startswith(f"{given}/")), None)
    if word and given != results:
        named = results + word.removeprefix(given)
        raise CraftmeshError(f"Snakemake does not expand the target {word!r}; write it as {named!r}")


def files_of(section: str, keys: Mapping[str, Any]) -> dict[str, str]:
    """Return the file names among a section's values, by key; names of built-in templates are left out."""
    found = {key: keys.get(key) for key in SECTION_FILES[section]}
    return {key: path for key, path in found.items() if path and path not in PRESETS}


def with_paths(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return `settings` with the file paths of sections and cracks expanded, as by `read_path`.

    Raises CraftmeshError that names the key.
    """
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
    """Return `text` with variables and the home folder expanded; a `$` before no name stays."""

    def value(found: re.Match) -> str:
        name = found[1] or found[2]
        if name not in os.environ:
            raise CraftmeshError(
                f"{key} is {text!r}, but the variable {name} is not set; set it, or write the path out"
            )
        return os.environ[name]

    path = os.path.expanduser(_VARIABLE.sub(value, text))
    if path.startswith("~"):
        raise CraftmeshError(
            f"{key} is {text!r}, but {path.split('/')[0]} is no user's home folder; write ~/ or ./~"
        )
    return path


def _for_commands(key: str, path: str) -> str:
    """Return `path` for rules and commands, absolute if it begins with `-`, so that it is no option.

    Raises CraftmeshError for braces, <name>, URLs, line breaks and other characters that commands cannot
    take.
    """
    found = _FILLED_IN.search(path)
    if found:
        raise CraftmeshError(
            f"{key} is {path!r}; expected a path without braces or <name>: Snakemake replaces them"
        )
    if _ADDRESS.match(path):
        raise CraftmeshError(f"{key} is {path!r}; expected a path in the file system, not a URL")
    if any(unicodedata.category(letter) in _BREAKING for letter in path):
        raise CraftmeshError(f"{key} is {path!r}; expected a path of one line, in UTF-8")
    path = str(Path(path))
    return os.path.abspath(path) if path.startswith("-") else path

"""The conda recipe asks for what pyproject.toml does, under conda's names."""

import re
import tomllib
from itertools import chain
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]
RECIPE = yaml.safe_load((ROOT / "packaging/conda/recipe.yaml").read_text())
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
# pip's name -> conda's
NAMES = {"matplotlib": "matplotlib-base", "pytetwild[all]": "pyvista", "snakemake": "snakemake-minimal"}


def asked_for(requirement: str, parted: str) -> tuple[str, str]:
    """Return the name and the versions of a requirement."""
    name, versions = re.fullmatch(rf"([\w.\[\]-]+){parted}(.*)", requirement).groups()
    return NAMES.get(name, name), versions.removeprefix("==")


def test_it_asks_for_the_packages_of_the_wheel():
    extras = PROJECT["optional-dependencies"]
    named = chain(*(packages for name, packages in extras.items() if name not in ("branches", "test")))
    everything = [*PROJECT["dependencies"], *named]
    wheel = {asked_for(name, "") for name in everything if not name.startswith("craftmesh")}
    run = {asked_for(requirement, " ?") for requirement in RECIPE["requirements"]["run"]}
    assert run - {("__linux", ""), ("python", PROJECT["requires-python"])} == wheel


def test_version_licence_and_command_are_the_packages():
    assert RECIPE["context"]["version"] == PROJECT["version"]
    assert RECIPE["about"]["license"] == PROJECT["license"]
    (command,) = RECIPE["build"]["python"]["entry_points"]
    assert dict([command.split(" = ")]) == PROJECT["scripts"]

"""Where the workflow and the demo lie, in a checkout and when installed, and when the demo runs."""

import os
import shutil
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from craftmesh.errors import CraftmeshError

PACKAGE = Path(__file__).parents[1]
NO_CONFIG = str(Path(__file__).with_name("no-config.yaml"))
DEFAULT = Path("config", "config.yaml")
# keys that say where and how a campaign runs; the others say which campaign it is
RUN_KEYS = frozenset({"results", "data", "chunks", "exports", "node"})


def home() -> Path:
    """Return the folder that holds `workflow` and `config`: the installed package or the checkout."""
    return PACKAGE if (PACKAGE / "workflow").is_dir() else PACKAGE.parent


def snakefile() -> Path:
    """Return the workflow's Snakefile, to be given to `snakemake -s` or to `module`."""
    return home() / "workflow" / "Snakefile"


def or_default(config: Mapping[str, Any]) -> dict[str, Any]:
    """Return `config` where it names a campaign, else the default campaign with `config` laid over it.

    A campaign is named by any key but results, data, chunks, exports and node; it never takes over values
    of the default one. The default is config/config.yaml in the folder in which Snakemake runs, or else
    the demo, whose sheet of cases lies beside it.
    """
    if not RUN_KEYS.issuperset(config):
        return dict(config)
    if DEFAULT.is_file():
        return read_config(DEFAULT) | dict(config)
    demo = read_config(home() / DEFAULT)
    return demo | {"cases": str(home() / demo["cases"])} | dict(config)


def command_on_path() -> None:
    """Let shells find the `craftmesh` command that lies beside this Python.

    Raises CraftmeshError where there is none, neither there nor elsewhere on the path.
    """
    beside = str(Path(sys.executable).parent)
    os.environ["PATH"] = os.pathsep.join([beside, os.environ.get("PATH", os.defpath)])
    if shutil.which("craftmesh") is None:
        raise CraftmeshError(
            f"the command craftmesh is not in {beside} nor on the path, but the rules call it; "
            f"install the package: {sys.executable} -m pip install {home()}"
        )


def read_config(path: Path) -> dict[str, Any]:
    """Return what a configuration file holds; raises CraftmeshError for what is not YAML with keys."""
    import yaml

    try:
        found = yaml.safe_load(path.read_text(encoding="utf-8"))
    except yaml.YAMLError as error:
        line = " ".join(str(error).split())
        raise CraftmeshError(f"{path}: {line}; expected YAML") from None
    except UnicodeDecodeError as error:
        raise CraftmeshError(f"{path}: {error}; expected YAML in UTF-8: save it anew") from None
    if not isinstance(found, dict):
        raise CraftmeshError(f"{path}: found {type(found).__name__}; expected keys with values")
    return found

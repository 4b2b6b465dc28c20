"""The subcommands of the command line: their order, modules and one-line summaries."""

import keyword
from pathlib import Path

# In the order in which a user needs them. The docstring of a subcommand's module begins with its help.
VERBS = (
    "init",
    "plan",
    "run",
    "demo",
    "status",
    "generate",
    "import",
    "remesh",
    "crack",
    "size",
    "preview",
    "stitch",
    "gradate",
    "tetrahedralize",
    "assemble",
    "renew",
    "inp",
    "solve",
    "fracture",
    "grow",
    "export",
    "check",
    "view",
    "depict",
    "report",
    "clean",
    "import-config",
    "snakefile",
    "compile",
    "completion",
)
COMMANDS = "craftmesh.commands"


def module_name(verb: str) -> str:
    """Return the name of a subcommand's module in the package `commands`."""
    return verb.replace("-", "_") + "_" * keyword.iskeyword(verb)


def summary(verb: str) -> str:
    """Return a subcommand's summary: the first line of its module's docstring, up to a colon or semicolon.

    The module is not imported, which would be slow. The first letter becomes small, a last point is
    removed.
    """
    import ast
    import re

    source = Path(__file__).with_name(f"{module_name(verb)}.py")
    first, *_ = (ast.get_docstring(ast.parse(source.read_bytes())) or "").splitlines()
    text = re.split("[:;]", first)[0].rstrip(".")
    return text[:1].lower() + text[1:]

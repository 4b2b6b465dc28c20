"""The verbs of the command line: their order, their modules, and what each does."""

import keyword
from pathlib import Path

# In the order of the way. The first words of the docstring of a verb's module are its help.
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
    """Return the name of a verb's module among the commands."""
    return verb.replace("-", "_") + "_" * keyword.iskeyword(verb)


def summary(verb: str) -> str:
    """Return what a verb does: its module's docstring to the first colon or semicolon, not imported."""
    import ast
    import re

    source = Path(__file__).with_name(f"{module_name(verb)}.py")
    first, *_ = (ast.get_docstring(ast.parse(source.read_bytes())) or "").splitlines()
    text = re.split("[:;]", first)[0].rstrip(".")
    return text[:1].lower() + text[1:]

"""Digest of a module's source and of all craftmesh modules that it imports.

Snakemake does not see changes in a library. A rule that carries its verb's digest as a parameter runs
again when, and only when, a module of its stage changes.
"""

import ast
import hashlib
import re
from functools import cache
from pathlib import Path

PACKAGE = "craftmesh"
# a dry run asks for 334 modules; their syntax trees took 0.9 of its 2.9 s, these expressions 0.02
FROM = re.compile(r"^[ \t]*from[ \t]+([\w.]+)[ \t]+import[ \t]+(\([^)]*\)|[^\n(]*)", re.M)
IMPORT = re.compile(rf"^[ \t]*import[ \t]+({PACKAGE}[\w.]*)", re.M)
# names of modules in texts, as for importlib or a worker process: "craftmesh.processes.worker:serve"
NAMED = re.compile(rf"\b{PACKAGE}(?:\.\w+)+")


def digest(module: str, root: Path | None = None) -> str:
    """Return 16 hexadecimal digits for `module` (dotted name) and its transitive craftmesh imports.

    Imports are found in the source, inside functions too, so nothing is imported; a module that is
    named in a text other than a docstring counts as well. `root` is the package's folder, by default
    this package's own. Raises FileNotFoundError for an unknown module.
    """
    root = Path(__file__).parents[1] if root is None else root
    found: set[str] = set()
    waiting = [module]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            waiting.extend(imports_of(name, root))
    total = hashlib.sha256()
    for name in sorted(found):
        total.update(name.encode() + b"\0" + _source(name, root) + b"\0")
    return total.hexdigest()[:16]


@cache
def source_file(module: str, root: Path) -> Path | None:
    """Return the file that holds `module`, or None where the package has no such module."""
    return _files(root).get(module)


@cache
def _files(root: Path) -> dict[str, Path]:
    """Return the package's files by the names of their modules."""
    found = {}
    for path in root.rglob("*.py"):
        parts = path.relative_to(root).with_suffix("").parts
        found[".".join([PACKAGE, *(parts[:-1] if parts[-1] == "__init__" else parts)])] = path
    return found


@cache
def _source(module: str, root: Path) -> bytes:
    file = source_file(module, root)
    if file is None:
        raise FileNotFoundError(f"module {module} is not in {root}")
    return file.read_bytes()


@cache
def imports_of(module: str, root: Path) -> tuple[str, ...]:
    """Return the craftmesh modules that `module` imports; parent packages are not followed."""
    text = _source(module, root).decode()
    names, starts = IMPORT.findall(text), FROM.findall(text)
    imported = sum("." in name for name in names)
    imported += sum(start.startswith(f"{PACKAGE}.") for start, _ in starts)
    for start, members in starts:
        base = _absolute(start, module, root)
        found = [f"{base}.{member}" for member in re.findall(r"\w+", members)]
        names += [name if source_file(name, root) else base for name in found]
    if len(NAMED.findall(text)) > imported:
        names += _named_in_texts(text)
    return tuple(name for name in dict.fromkeys(names) if source_file(name, root))


def _absolute(start: str, module: str, root: Path) -> str:
    """Return the dotted name from which `module` imports, for one that starts with points as well."""
    name = start.lstrip(".")
    points = len(start) - len(name)
    if not points:
        return name
    file = source_file(module, root)
    up = points - 1 if file and file.name == "__init__.py" else points
    return ".".join([*module.split(".")[: -up or None], *([name] if name else [])])


def _named_in_texts(text: str) -> list[str]:
    """Return what looks like a module in the texts of a source that are no docstrings."""
    nodes = list(ast.walk(ast.parse(text)))
    docstrings = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    values = [node.value for node in nodes if isinstance(node, ast.Constant) and id(node) not in docstrings]
    return [name for value in values if isinstance(value, str) for name in NAMED.findall(value)]

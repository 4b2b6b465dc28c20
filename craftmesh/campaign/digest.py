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
        total.update(name.encode() + b"\0" + _existing(name, root).read_bytes() + b"\0")
    return total.hexdigest()[:16]


@cache
def source_file(module: str, root: Path) -> Path | None:
    """Return the file that holds `module`, or None where the package has no such module."""
    path = root.joinpath(*module.split(".")[1:])
    for candidate in (path.with_suffix(".py"), path / "__init__.py"):
        if module.split(".")[0] == PACKAGE and candidate.is_file():
            return candidate
    return None


def _existing(module: str, root: Path) -> Path:
    file = source_file(module, root)
    if file is None:
        raise FileNotFoundError(f"module {module} is not in {root}")
    return file


@cache
def imports_of(module: str, root: Path) -> tuple[str, ...]:
    """Return the craftmesh modules that `module` imports; parent packages are not followed."""
    file = _existing(module, root)
    package = module if file.name == "__init__.py" else module.rpartition(".")[0]
    names: list[str] = []
    nodes = list(ast.walk(ast.parse(file.read_bytes())))
    docstrings = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    for node in nodes:
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parent = package.rsplit(".", node.level - 1)[0] if node.level > 1 else package
                base = f"{parent}.{base}" if base else parent
            members = [f"{base}.{alias.name}" for alias in node.names]
            names += [name if source_file(name, root) else base for name in members]
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docstrings:
            names += NAMED.findall(node.value)
    return tuple(name for name in names if source_file(name, root))

"""Digest of the source of a module and of all craftmesh modules that it imports.

Snakemake does not see changes in a library. A rule has the digest of its subcommand as a parameter, so
it runs again when, and only when, a module of its stage changes.
"""

import hashlib
import re
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parents[1]
# Import statements, by regular expressions: `ast.parse` of all modules took 0.9 s of a 2.9 s dry run.
FROM = re.compile(r"^[ \t]*from[ \t]+(craftmesh[\w.]*)[ \t]+import[ \t]+(\([^)]*\)|[^\n(]*)", re.M)
IMPORT = re.compile(r"^[ \t]*import[ \t]+(craftmesh[\w.]*)", re.M)


@cache
def digest(module: str, root: Path = PACKAGE) -> str:
    """Return 16 hexadecimal digits for `module` (dotted name) and its transitive craftmesh imports.

    Import statements are found in the source text, also inside functions, so nothing is imported. `root`
    is the package's folder. Raises FileNotFoundError for an unknown module.
    """
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
    """Return the source file of `module`, or None if the package in `root` has no such module."""
    top, *names = module.split(".")
    stem = root.joinpath(*names)
    files = (stem.with_suffix(".py"), stem / "__init__.py")
    return next((file for file in files if top == root.name and file.is_file()), None)


@cache
def _source(module: str, root: Path) -> bytes:
    file = source_file(module, root)
    if file is None:
        raise FileNotFoundError(f"module {module} is not in {root}")
    return file.read_bytes()


@cache
def imports_of(module: str, root: Path) -> tuple[str, ...]:
    """Return the dotted names of craftmesh modules that `module` imports, without their parent packages."""
    text = _source(module, root).decode()
    names = IMPORT.findall(text)
    for base, members in FROM.findall(text):
        found = [f"{base}.{member}" for member in re.findall(r"\w+", members)]
        names += [name if source_file(name, root) else base for name in found]
    return tuple(name for name in dict.fromkeys(names) if source_file(name, root))

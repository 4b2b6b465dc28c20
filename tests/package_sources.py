"""The modules of the package, their sources and what they import, read without importing them."""

import ast
from pathlib import Path

import craftmesh

ROOT = Path(craftmesh.__file__).parent


def modules() -> list[str]:
    """Return the dotted names of all modules of the package but the package itself."""
    files = (file.relative_to(ROOT.parent).with_suffix("") for file in ROOT.rglob("*.py"))
    names = (".".join(file.parts).removesuffix(".__init__") for file in files)
    return sorted(name for name in names if name != craftmesh.__name__)


def imports_of(module: str) -> set[str]:
    found: set[str] = set()
    for node in ast.walk(ast.parse(source(module))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{module}: a relative import"
            found |= {
                node.module if node.module != craftmesh.__name__ else f"{node.module}.{alias.name}"
                for alias in node.names
            }
    return {name for name in found if name.split(".")[0] == craftmesh.__name__}


def is_package(module: str) -> bool:
    return (_path(module) / "__init__.py").exists()


def source(module: str) -> str:
    path = _path(module)
    return (path / "__init__.py" if is_package(module) else path.with_suffix(".py")).read_text()


def _path(module: str) -> Path:
    return ROOT.joinpath(*module.split(".")[1:])

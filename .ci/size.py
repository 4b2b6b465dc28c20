"""Print the package's lines and its tuned numbers; fail where one is above its figure in pyproject.toml.

A tuned number is a constant at the top of a module that is a number, or made of numbers by arithmetic.
"""

import ast
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def is_number(value: ast.expr | None) -> bool:
    if isinstance(value, ast.BinOp):
        return is_number(value.left) and is_number(value.right)
    if isinstance(value, ast.UnaryOp):
        value = value.operand
    return isinstance(value, ast.Constant) and type(value.value) in (int, float)


def size(package: Path) -> dict[str, int]:
    """Return the lines of a package's modules and the number of their tuned numbers."""
    sources = [path.read_text(encoding="utf-8") for path in package.rglob("*.py")]
    constants = [
        node
        for source in sources
        for node in ast.parse(source).body
        if isinstance(node, ast.Assign | ast.AnnAssign) and is_number(node.value)
    ]
    return {"lines": sum(source.count("\n") for source in sources), "numbers": len(constants)}


def main() -> str | None:
    most = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["craftmesh"]
    found = size(ROOT / "craftmesh")
    print("craftmesh:", *(f"{count} {name} (at most {most[name]})" for name, count in found.items()))
    above = [name for name, count in found.items() if count > most[name]]
    return f"pyproject.toml, [tool.craftmesh]: {' and '.join(above)} above the figure" if above else None


if __name__ == "__main__":
    sys.exit(main())

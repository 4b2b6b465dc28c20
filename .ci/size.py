"""Print the package's lines of code and tuned numbers; fail if one is above its figure in pyproject.toml.

A line of code is neither blank nor only a comment, a docstring or an import. A tuned number is
a module's constant, the default of a field or an argument, or a fraction within the value of either.
"""

import ast
import io
import sys
import tokenize
import tomllib
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
NO_CODE = {
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENDMARKER,
}


def code_lines(source: str, tree: ast.Module) -> int:
    """Return the number of a module's lines of code."""
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    lines = {line for t in tokens if t.type not in NO_CODE for line in range(t.start[0], t.end[0] + 1)}
    no_code = [node for node in ast.walk(tree) if isinstance(node, ast.Import | ast.ImportFrom)]
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(node):
            no_code.append(node.body[0])
    return len(lines.difference(*(range(node.lineno, node.end_lineno + 1) for node in no_code)))


def is_number(value: ast.expr) -> bool:
    """Return whether a value is a number, or made of numbers by arithmetic."""
    if isinstance(value, ast.BinOp):
        return is_number(value.left) and is_number(value.right)
    if isinstance(value, ast.UnaryOp):
        value = value.operand
    return isinstance(value, ast.Constant) and type(value.value) in (int, float)


def values(tree: ast.Module) -> Iterator[ast.expr]:
    """Yield the values of a module's constants and fields, and of its functions' defaults."""
    bodies = [tree.body, *(node.body for node in ast.walk(tree) if isinstance(node, ast.ClassDef))]
    for node in (node for body in bodies for node in body):
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value:
            names = node.targets[0] if isinstance(node, ast.Assign) else node.target
            unpacked = isinstance(names, ast.Tuple) and isinstance(node.value, ast.Tuple)
            yield from node.value.elts if unpacked else [node.value]
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.Lambda):
            yield from (d for d in [*node.args.defaults, *node.args.kw_defaults] if d is not None)


def tuned_numbers(tree: ast.Module) -> int:
    """Return the number of a module's tuned numbers; in tables whole numbers, 0 and 1 are not counted."""
    alone = [value for value in values(tree) if is_number(value)]
    within = [part for value in values(tree) if not is_number(value) for part in ast.walk(value)]
    fractions = [
        part
        for part in within
        if isinstance(part, ast.Constant) and type(part.value) is float and part.value not in (0.0, 1.0)
    ]
    return len(alone) + len(fractions)


def size(package: Path) -> dict[str, int]:
    """Return a package's lines of code and its tuned numbers."""
    sources = [path.read_text(encoding="utf-8") for path in sorted(package.rglob("*.py"))]
    modules = [(source, ast.parse(source)) for source in sources]
    return {
        "lines": sum(code_lines(source, tree) for source, tree in modules),
        "numbers": sum(tuned_numbers(tree) for _, tree in modules),
    }


def main() -> str | None:
    most = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["craftmesh"]
    found = size(ROOT / "craftmesh")
    print("craftmesh:", *(f"{count} {name} (at most {most[name]})" for name, count in found.items()))
    above = [name for name, count in found.items() if count > most[name]]
    return f"pyproject.toml, [tool.craftmesh]: {' and '.join(above)} above the figure" if above else None


if __name__ == "__main__":
    sys.exit(main())

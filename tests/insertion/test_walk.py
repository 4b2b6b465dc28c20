"""How many files a reader opens who follows `insert_crack` from the call to the crack's facets."""

import ast

from package_sources import source

ROOMS = ("craftmesh.insertion.", "craftmesh.cracks.")
FILES = 20  # of both rooms, without their options


def definitions(module: str) -> tuple[dict[str, ast.AST], dict[str, tuple[str, str]]]:
    """Return a module's functions and classes, and for each name it imports module and name there."""
    tree = ast.parse(source(module))
    own = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module]
    return own, {a.asname or a.name: (node.module, a.name) for node in imports for a in node.names}


def reached(start: tuple[str, str]) -> set[str]:
    """Return the modules of both rooms with a function or a class that a function's code leads to by name.

    A class leads to all that its methods do.
    """
    seen, waiting = set(), [start]
    while waiting:
        module, name = waiting.pop()
        if (module, name) in seen or not module.startswith(ROOMS):
            continue
        own, imported = definitions(module)
        if name not in own:
            continue
        seen.add((module, name))
        names = {node.id for node in ast.walk(own[name]) if isinstance(node, ast.Name)}
        waiting += [(module, other) for other in names & own.keys()]
        waiting += [imported[other] for other in names & imported.keys()]
    return {module for module, _ in seen if not module.endswith(".options")}


def test_insert_crack_is_followed_in_few_files():
    files = reached(("craftmesh.insertion.insert", "insert_crack"))
    assert len(files) <= FILES, sorted(files)
    assert {"craftmesh.insertion.crack_patch", "craftmesh.cracks.near_sheet"} <= files

"""Digests follow imports, and nothing else."""

import ast
import shutil
from pathlib import Path

import pytest

import craftmesh
from craftmesh.campaign.digest import digest, imports_of, source_file


@pytest.fixture
def package(tmp_path) -> Path:
    """A small package: stage `a` imports `shared` inside a function, stage `b` by another module."""
    root = tmp_path / "craftmesh"
    (root / "kernels").mkdir(parents=True)
    (root / "__init__.py").write_text("from craftmesh.a import run\n")
    (root / "kernels" / "__init__.py").write_text("")
    (root / "a.py").write_text("def run():\n    from craftmesh.shared import x\n")
    (root / "b.py").write_text("import numpy\nfrom craftmesh.kernels import swap\n")
    (root / "shared.py").write_text("x = 1\n")
    (root / "kernels" / "swap.py").write_text("from craftmesh.shared import x\n")
    (root / "c.py").write_text('"""Unlike craftmesh.shared."""\nimport craftmesh.mesher\n')
    (root / "mesher.py").write_text("class Mesher: pass\n")
    return root


def changed_by(package: Path, tmp_path: Path, touched: str) -> set[str]:
    """Return the stages whose digest changes when a module does."""
    other = tmp_path / "other" / "craftmesh"
    shutil.copytree(package, other)
    with open(other / touched, "a") as stream:
        stream.write("# touched\n")
    stages = ("craftmesh.a", "craftmesh.b", "craftmesh.c")
    return {stage[-1] for stage in stages if digest(stage, package) != digest(stage, other)}


@pytest.mark.parametrize(
    ("touched", "stages"),
    [
        ("shared.py", "ab"),
        ("kernels/swap.py", "b"),
        ("a.py", "a"),
        ("c.py", "c"),
        ("mesher.py", "c"),
        ("__init__.py", ""),
    ],
)
def test_change_reaches_the_stages_that_import_it(package, tmp_path, touched, stages):
    assert changed_by(package, tmp_path, touched) == set(stages)


def test_digest_does_not_depend_on_the_place(package, tmp_path):
    moved = shutil.copytree(package, tmp_path / "moved" / "craftmesh")
    assert digest("craftmesh.b", package) == digest("craftmesh.b", moved)


def test_unknown_module_is_refused(package):
    with pytest.raises(FileNotFoundError, match="craftmesh.nothing"):
        digest("craftmesh.nothing", package)


def test_stages_of_the_real_package_have_their_own_digests():
    root = Path(craftmesh.__file__).parent
    verbs = [path.stem for path in (root / "commands").glob("*.py") if "add_arguments" in path.read_text()]
    digests = {digest(f"craftmesh.commands.{verb}") for verb in verbs}
    assert len(digests) == len(verbs) > 8


def imports_by_syntax(module: str, root: Path) -> set[str]:
    """Return what a module imports, by its syntax tree; all imports are absolute."""
    file = source_file(module, root)
    assert file is not None
    nodes = list(ast.walk(ast.parse(file.read_text())))
    names: set[str] = set()
    for node in nodes:
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert not node.level
            members = {f"{node.module}.{alias.name}" for alias in node.names}
            names |= {name if source_file(name, root) else str(node.module) for name in members}
    return {name for name in names if source_file(name, root)}


def test_every_module_of_the_real_package_imports_what_its_syntax_says():
    root = Path(craftmesh.__file__).parent
    parts = [path.relative_to(root).with_suffix("").parts for path in root.rglob("*.py")]
    modules = [".".join(["craftmesh", *names]).removesuffix(".__init__") for names in parts]
    assert len(modules) > 300
    assert [name for name in modules if set(imports_of(name, root)) != imports_by_syntax(name, root)] == []

"""The core imports the packages of `dependencies`; all others come through the door of an extra."""

import ast
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from package_sources import modules, source

from craftmesh.errors import CraftmeshError
from craftmesh.extras import extra

PROJECT = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["project"]
EXTRAS = PROJECT["optional-dependencies"]
# The modules of packages that are imported under another name, or that another package brings.
MODULES = {"pynrrd": "nrrd", "pillow": "PIL", "pyyaml": "yaml"}
BROUGHT = {"llvmlite": "numba", "markupsafe": "jinja2", "mpl_toolkits": "matplotlib"}
NOT_IMPORTED = {"lxml", "snakemake-executor-plugin-slurm"}  # by trimesh, by Snakemake
OF_ABAQUS = "craftmesh.processes.abaqus_displacements"  # runs in Abaqus' Python
DOORED = ("formats", "pictures", "spectrum", "tetwild", "workflow")


def imported_by(requirements: list[str]) -> set[str]:
    """Return the modules that the packages of requirements are imported as."""
    names = {re.match(r"[\w-]+", text).group() for text in requirements} - NOT_IMPORTED - {"craftmesh"}
    return {MODULES.get(name, name) for name in names}


def foreign_imports() -> set[tuple[str, str, str]]:
    """Return (module, imported package, extra of the `with` around it or "") of the package."""
    found = set()

    def visit(node, module, name):
        if isinstance(node, ast.With) and isinstance(call := node.items[0].context_expr, ast.Call):
            if isinstance(call.func, ast.Name) and call.func.id == "extra":
                name = call.args[0].value
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            return
        targets = [node.module] if isinstance(node, ast.ImportFrom) else []
        targets += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        found.update((module, target.partition(".")[0], name) for target in targets)
        for child in ast.iter_child_nodes(node):
            visit(child, module, name)

    for module in modules():
        visit(ast.parse(source(module)), module, "")
    own = {*sys.stdlib_module_names, "craftmesh"}
    return {row for row in found if row[1] not in own and row[0] != OF_ABAQUS}


def test_imports_are_those_of_pyproject():
    found = foreign_imports()
    required = {"": PROJECT["dependencies"], **{door: EXTRAS[door] for door in DOORED}}
    for door, packages in required.items():
        imported = {BROUGHT.get(package, package) for _, package, name in found if name == door}
        assert imported == imported_by(packages), door
    assert {name for _, _, name in found} == {"", *DOORED}


def test_all_has_every_extra_of_users():
    inside = re.search(r"\[(.*)\]", EXTRAS["all"][0]).group(1).split(",")
    assert set(inside) == set(EXTRAS) - {"all", "branches", "test"}


def without_extras(code: str) -> str:
    """Return code that runs where the packages of extras are not found."""
    missing = sorted(set().union(*(imported_by(EXTRAS[door]) for door in DOORED)))
    return (
        "import importlib.abc, importlib.metadata, sys\n"
        "class Missing(importlib.abc.MetaPathFinder):\n"
        "    def find_spec(self, name, path, target=None):\n"
        f"        if name in {missing}:\n"
        "            raise ModuleNotFoundError(name, name=name)\n"
        "sys.meta_path.insert(0, Missing())\n"
        "present = importlib.metadata.version\n"
        "def version(name):\n"
        f"    if name in {missing}:\n"
        "        raise importlib.metadata.PackageNotFoundError(name)\n"
        "    return present(name)\n"
        "importlib.metadata.version = version\n"
    ) + code


def run(code: str, cwd: Path) -> subprocess.CompletedProcess:
    words = [sys.executable, "-c", without_extras(code)]
    return subprocess.run(words, cwd=cwd, capture_output=True, text=True)


def verb(*words: str) -> str:
    return f"from craftmesh.cli import main; sys.exit(main({list(words)}))"


@pytest.mark.parametrize(
    ("package", "name", "words"),
    [
        ("h5py", "formats", ("import", "a.dream3d", "--labels", "l.npz")),
        ("tifffile", "formats", ("import", "a.tif", "--labels", "l.npz")),
        ("pynrrd", "formats", ("import", "a.nrrd", "--labels", "l.npz")),
        ("trimesh", "formats", ("stitch", "folder", "-o", "s.vtp")),
        ("meshio", "formats", ("view", "a.inp")),
        ("matplotlib", "pictures", ("view", "a.npz")),
        ("matplotlib", "pictures", ("preview", "a.vtp", "b.vtp", "-o", "c.png")),
        ("matplotlib", "pictures", ("report", "results", "-o", "r.html")),
        ("psutil", "workflow", ("run", "mine.yaml")),
        ("psutil", "workflow", ("demo",)),
        ("shtab", "workflow", ("completion", "bash")),
        ("jsonschema", "workflow", ("plan", "config.yaml")),
    ],
)
def test_a_verb_without_its_extra_is_one_line(tmp_path, package, name, words):
    for file in ("a.dream3d", "a.tif", "a.nrrd", "a.inp", "folder/1.stl", "config.yaml"):
        (tmp_path / file).parent.mkdir(exist_ok=True)
        (tmp_path / file).write_text("cases: cases.csv\n")
    labels = "import numpy as np; np.savez('a.npz', labels=np.ones((3, 3, 3), int), spacing=np.ones(3))\n"
    done = run(labels + verb(*words), tmp_path)
    line = f"the package {package} is not installed; get the extra {name}: pip install 'craftmesh[{name}]'"
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.count("\n") == 1 and done.stderr.endswith(f"{line}\n")


def test_help_needs_no_extra(tmp_path):
    done = run(verb("--help"), tmp_path)
    assert done.returncode == 0 and "tetrahedralize" in done.stdout


def test_tetwild_is_missed_before_a_process_starts():
    code = "from craftmesh.tetrahedra.whole.whole_model import mesh_whole_model as mesh; mesh(0, 0, 0)"
    done = run(code, Path.cwd())
    assert "the package pytetwild is not installed; get the extra tetwild" in done.stderr


def test_other_errors_pass_the_door():
    with pytest.raises(CraftmeshError, match="package anything is not installed; get the extra formats"):
        with extra("formats"):
            import anything.of_a_kind  # noqa: F401
    with pytest.raises(ImportError, match="cannot import name"), extra("formats"):
        from ast import no_such_name  # noqa: F401


@pytest.mark.slow  # a dozen processes, one a verb
def test_verbs_from_labels_to_a_deck_need_no_extra(tmp_path):
    crack, sizing = ("--crack", "crack.vtp"), ("--sizing", "sizing.npz")
    shape = ("--shape", "penny", "--centre", "0", "4.5", "4", "--normal", "0", "0", "1", "--radius", "3")
    material = ("--material", "isotropic:70000,0.3")
    chain = (
        ("generate", "--shape", "10", "9", "8", "--grains", "2", "-o", "generated.npz"),
        ("import", "generated.npz", "--labels", "labels.npz", "--islands", "islands.json"),
        ("remesh", "labels.npz", "-o", "remeshed.vtp"),
        ("crack", "labels.npz", *shape, "-o", "crack.vtp"),
        ("size", "remeshed.vtp", *crack, "--l-min", "0.9", "--l-max", "2", "-o", "sizing.npz"),
        ("stitch", "remeshed.vtp", *crack, *sizing, "-o", "surface.vtp"),
        ("gradate", "surface.vtp", *crack, *sizing, "-o", "gradated.vtp"),
        ("tetrahedralize", "gradated.vtp", *crack, *sizing, "-o", "volume.vtu", "--front-csv", "front.csv"),
        ("inp", "volume.vtu", "--microstructure", "labels.npz", *material, "-o", "model.inp"),
        ("check", "model.inp"),
    )
    for words in chain:
        done = run(verb(*words), tmp_path)
        assert done.returncode == 0, (words, done.stderr)

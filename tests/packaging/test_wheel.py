"""The package that strangers get: what a wheel holds, and that it runs where nothing of the tree is."""

import importlib.metadata
import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
NOT_BUILT = shutil.ignore_patterns(".*", "__pycache__", "build", "*.egg-info", "results", "data")
# folders of the tree and where a wheel has them
CARRIED = {
    "craftmesh": "craftmesh",
    "workflow": "craftmesh/workflow",
    "profiles": "craftmesh/workflow/profiles",
    "config": "craftmesh/config",
}


def run(*command: str | Path, cwd: Path, **variables: str) -> str:
    """Run a command that has to succeed in `cwd`, and return what it printed."""
    env = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}  # which has the tree
    done = subprocess.run(
        [str(word) for word in command],
        cwd=cwd,
        env=env | variables,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=1800,  # compilation on a busy machine
    )
    assert done.returncode == 0, done.stdout
    return done.stdout


def pip() -> list[str]:
    """Return a pip that can install elsewhere; the tests' own environment has none."""
    for python in (sys.executable, Path(sys.base_prefix, "bin", "python3"), shutil.which("python3")):
        if python and not subprocess.run([python, "-m", "pip", "-V"], capture_output=True).returncode:
            return [str(python), "-m", "pip"]
    pytest.skip("no pip is on this machine, neither in the tests' environment nor in the Python beneath it")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    """A wheel of a copy of the tree; skips where pip cannot get setuptools, which builds it."""
    folder = tmp_path_factory.mktemp("wheel")
    tree = shutil.copytree(ROOT, folder / "tree", ignore=NOT_BUILT)
    done = subprocess.run(
        [*pip(), "wheel", "--no-deps", "-w", str(folder), str(tree)], capture_output=True, text=True
    )
    if "No matching distribution found for setuptools" in done.stderr + done.stdout:
        pytest.skip("pip cannot get setuptools, which builds the wheel (no package index within reach)")
    assert done.returncode == 0, done.stderr
    return next(folder.glob("craftmesh-*.whl"))


def environment(wheel: Path, folder: Path) -> Path:
    """Return the bin folder of a new environment with the wheel; other packages are those of the tests."""
    venv.create(folder, with_pip=False)
    run(*pip(), "--python", folder / "bin" / "python", "install", "--no-deps", wheel, cwd=folder)
    site = Path(sysconfig.get_path("purelib", vars={"base": str(folder)}))
    # .pth files in a folder that is named in one are not followed: the editable craftmesh stays out
    (site / "others.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return folder / "bin"


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory) -> Path:
    return environment(wheel, tmp_path_factory.mktemp("installed") / "venv")


def test_wheel_holds_every_module_and_file_of_the_package(wheel):
    names = set(zipfile.ZipFile(wheel).namelist())
    for folder, place in CARRIED.items():
        files = [path for path in (ROOT / folder).rglob("*") if path.is_file()]
        files = [path for path in files if path.parent.name != "__pycache__"]
        assert files
        missing = {f"{place}/{path.relative_to(ROOT / folder)}" for path in files} - names
        assert not missing, f"the wheel lacks {sorted(missing)}"
    rooms = {name.split("/")[0] for name in names if ".dist-info" not in name}
    assert rooms == {"craftmesh"}


@pytest.fixture(scope="module")
def labels(installed, tmp_path_factory) -> Path:
    """A tiny polycrystal that the installed command made and imported."""
    folder = tmp_path_factory.mktemp("labels")
    craftmesh = installed / "craftmesh"
    run(craftmesh, "generate", "--shape", 6, 5, 4, "--grains", 2, "-o", "generated.npz", cwd=folder)
    run(craftmesh, "import", "generated.npz", "--labels", "labels.npz", cwd=folder)
    return folder / "labels.npz"


def test_installed_command_makes_and_checks_a_microstructure(installed, labels, tmp_path):
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    assert run(installed / "craftmesh", "--version", cwd=tmp_path) == f"craftmesh {version}\n"
    run(installed / "craftmesh", "check", labels, cwd=tmp_path)


@pytest.mark.slow  # the kernels of a new installation compile, 40 s of one core
def test_installed_command_remeshes(installed, labels, tmp_path):
    run(installed / "craftmesh", "remesh", labels, "-o", "remeshed.vtp", cwd=tmp_path)
    run(installed / "craftmesh", "check", "remeshed.vtp", cwd=tmp_path)


@pytest.fixture(scope="module")
def with_code(wheel, tmp_path_factory) -> Path:
    """The bin folder of a new environment with the wheel that has the kernels' machine code."""
    folder = tmp_path_factory.mktemp("with_code")
    run(ROOT / ".ci/wheel", wheel, sys.executable, folder, cwd=folder)
    (made,) = folder.glob("craftmesh-*.whl")
    assert "-none-any" not in made.name
    return environment(made, folder / "venv")


SIZES = "--l-min 0.8 --l0 1 --l-max 2 --r0 2 --r1 4"
MODEL = "--microstructure labels.npz --material cubic:168400,121400,75400"
TO_SOLUTION = (
    "generate --shape 12 13 14 --grains 3 --seed 2 -o generated.npz",
    "import generated.npz --labels labels.npz --image volume.vti --islands islands.json",
    "remesh labels.npz -o remeshed.vtp",
    "crack labels.npz --centre 6 6 7.2 --normal 0 0.3 1 --radius 3 -o crack.vtp",
    f"size remeshed.vtp --crack crack.vtp --labels labels.npz {SIZES} -o sizing.npz",
    "stitch remeshed.vtp --crack crack.vtp --sizing sizing.npz -o surface.vtp",
    "gradate surface.vtp --crack crack.vtp --sizing sizing.npz -o gradated.vtp",
    "tetrahedralize gradated.vtp --islands islands.json --sizing sizing.npz -o volume.vtu",
    f"inp volume.vtu {MODEL} -o model.inp",
    f"solve volume.vtu {MODEL} -o solution.npz",
)


@pytest.mark.slow  # all kernels compile into the wheel, two minutes of one core
def test_a_wheel_with_machine_code_compiles_nothing_until_a_source_is_changed(with_code, tmp_path):
    package = Path(
        run(
            with_code / "python", "-c", "import craftmesh; print(*craftmesh.__path__)", cwd=tmp_path
        ).strip()
    )
    assert package.is_relative_to(with_code.parent)
    own = {"NUMBA_CACHE_DIR": str(tmp_path / "kernels")}
    for line in TO_SOLUTION:
        run(with_code / "craftmesh", *line.split(), cwd=tmp_path, **own)
    assert list(tmp_path.rglob("*.nb[ic]")) == []
    kernels = package / "voxels" / "kernels" / "pieces.py"
    kernels.write_text(kernels.read_text() + "# changed\n")
    run(with_code / "craftmesh", *TO_SOLUTION[1].split(), cwd=tmp_path, **own)
    compiled = {path.name.partition(".")[0] for path in tmp_path.rglob("*.nbc")}
    assert "pieces" in compiled


def test_installed_workflow_is_taken_in_from_an_empty_folder(installed, tmp_path):
    snakefile = Path(run(installed / "craftmesh", "snakefile", cwd=tmp_path).strip())
    assert snakefile.is_relative_to(installed.parent)
    (tmp_path / "Snakefile").write_text(
        f'module craftmesh:\n    snakefile: "{snakefile}"\nuse rule * from craftmesh\n'
    )
    run(installed / "python", "-m", "snakemake", "--cores", 1, "results/demo/generated.npz", cwd=tmp_path)
    assert (tmp_path / "results" / "demo" / "generated.npz").is_file()


def test_citation_has_the_packages_version_and_licence():
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert (cited["version"], cited["license"]) == (project["version"], project["license"])
    assert cited["version"] == importlib.metadata.version("craftmesh")
    deposited = json.loads((ROOT / ".zenodo.json").read_text())
    assert (deposited["version"], deposited["license"]) == (cited["version"], cited["license"])
    assert deposited["title"] == cited["title"]


def test_gradation_alone_needs_four_packages():
    """Who wants the library alone may install these and craftmesh without its dependencies."""
    code = "import sys, craftmesh; craftmesh.gradate; print(*{name.split('.')[0] for name in sys.modules})"
    loaded = set(run(sys.executable, "-c", code, cwd=ROOT).split())
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    needed = {re.split("[>=]", name)[0].replace("pyyaml", "yaml") for name in project["dependencies"]}
    assert needed & loaded <= {"numba", "numpy", "scipy", "yaml"}

"""Compiled kernels are never older than the sources of the kernels that they call."""

import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from package_sources import imports_of, is_package, modules, source

from craftmesh import jit, kernel_code, kernel_structs, wheel_code

CALLEE = """from numba import njit
from craftmesh.jit import kernel

@{decorator}
def scaled(x):
    return {factor} * x
"""
CALLER = """from numba import njit
from craftmesh.jit import kernel
from craftmesh.kernels.callee import scaled

@{decorator}
def scaled_sum(x, y):
    return scaled(x) + scaled(y)
"""
RUN = """
from craftmesh.kernels.caller import scaled_sum
print(scaled_sum({arguments}), sum(scaled_sum.stats.cache_hits.values()))
"""


class Package:
    """A package named craftmesh with one kernel that calls another, in a file of its own."""

    def __init__(self, folder: Path, decorator: str):
        self.folder = folder
        self.decorator = decorator
        self.kernels = folder / "craftmesh" / "kernels"
        self.kernels.mkdir(parents=True)
        for file in (self.kernels / "__init__.py", folder / "craftmesh" / "__init__.py"):
            file.write_text("")
        for module in (kernel_structs, jit, kernel_code, wheel_code):
            shutil.copy(module.__file__, folder / "craftmesh")
        (self.kernels / "caller.py").write_text(CALLER.format(decorator=decorator))

    def scale_by(self, factor: int) -> None:
        text = CALLEE.format(decorator=self.decorator, factor=factor)
        (self.kernels / "callee.py").write_text(text)

    def run(self, arguments: str = "1, 2", script: str = RUN, **environment: str) -> list[float]:
        """Return what a process of its own prints: the caller's value, and the hits in the cache."""
        kept = {key: value for key, value in os.environ.items() if not key.startswith("NUMBA")}
        kept |= {"PYTHONPATH": str(self.folder), "PYTHONDONTWRITEBYTECODE": "1"}
        command = [sys.executable, "-c", script.format(arguments=arguments)]
        done = subprocess.run(
            command, capture_output=True, text=True, cwd=self.folder, env=kept | environment
        )
        assert done.returncode == 0, done.stderr
        return [float(word) for word in done.stdout.split()]

    def files(self, folder: Path | None = None) -> set[str]:
        return {file.name for file in (folder or self.kernels).rglob("*.nb[ic]")}


@pytest.fixture
def package(tmp_path) -> Package:
    made = Package(tmp_path, "kernel")
    made.scale_by(3)
    return made


def test_a_changed_callee_is_compiled_in_and_old_files_go(package):
    assert package.run() == [9, 0]
    before = package.files()
    assert package.run() == [9, 1]
    package.scale_by(5)
    assert package.run() == [15, 0]
    assert package.run() == [15, 1]
    assert len(package.files()) == len(before)
    assert not package.files() & before


def test_code_from_the_cache_loads_nothing_that_compiles_until_something_must(package):
    loaded = "\nprint(int('numba.np.random.generator_core' in sys.modules))"
    script = f"import sys{RUN}{loaded}\nprint(scaled_sum(1.5, 2)){loaded}"
    assert package.run(script=script) == [9, 0, 1, 10.5, 1]
    for file in package.kernels.rglob("*.2-*.nbc"):
        file.unlink()  # the machine code of the second call
    assert package.run(script=script) == [9, 1, 0, 10.5, 1]


@pytest.mark.slow
def test_the_reason_stands_numba_alone_runs_the_old_callee(tmp_path):
    package = Package(tmp_path, "njit(cache=True)")
    package.scale_by(3)
    assert package.run() == [9, 0]
    package.scale_by(5)
    assert package.run() == [9, 1], "numba sees the change now: craftmesh.jit may go"


def test_the_users_cache_folder_is_used(package, tmp_path):
    folder = tmp_path / "cache"
    assert package.run(NUMBA_CACHE_DIR=str(folder)) == [9, 0]
    assert package.run(NUMBA_CACHE_DIR=str(folder)) == [9, 1]
    assert package.files(folder)
    assert not package.files()


@pytest.mark.slow
def test_a_read_only_package_compiles_into_the_users_folder_or_for_itself(package, tmp_path):
    (package.kernels / "__pycache__").write_text("a file here lets nobody make the folder")
    home = tmp_path / "home"
    for hits in (0, 1):
        assert package.run(HOME=str(home), XDG_CACHE_HOME=str(home)) == [9, hits]
    assert package.files(home)
    assert package.run(HOME=os.devnull, XDG_CACHE_HOME=os.devnull) == [9, 0]


@pytest.fixture
def wheel(package) -> Package:
    """The package with code for a level of CPUs, as a wheel has it, and nothing in the cache."""
    target = wheel_code.LEVELS.get(wheel_code.get_process_triple())
    if target is None:
        pytest.skip("wheels have no code for this platform")
    folder = package.folder / "craftmesh" / "machine_code"
    name, features = target
    made = {"NUMBA_CACHE_DIR": "made", "NUMBA_CPU_NAME": name, "NUMBA_CPU_FEATURES": features}
    assert package.run(**made) == [9, 0]
    folder.mkdir()
    for file in (package.folder / "made").rglob("*.nb[ic]"):
        file.rename(folder / file.name)
    return package


def test_code_of_a_wheel_is_run_and_nothing_is_compiled_or_written(wheel):
    before = wheel.files()
    assert wheel.run() == [9, 1]
    assert wheel.run(HOME=os.devnull, XDG_CACHE_HOME=os.devnull) == [9, 1]
    assert wheel.files() == before == set()


def test_other_signatures_are_compiled_beside_those_of_a_wheel(wheel):
    assert wheel.run("1.5, 2") == [10.5, 0]
    assert wheel.run("1.5, 2") == [10.5, 1]
    assert wheel.run() == [9, 1]


def test_a_wheel_whose_sources_were_changed_compiles_anew(wheel):
    wheel.scale_by(5)
    assert wheel.run() == [15, 0]
    assert wheel.run() == [15, 1]
    wheel.scale_by(3)
    assert wheel.run() == [9, 1], "the code of the wheel fits again"


# a CPU that lacks features; code that checks bounds; another numpy; another CPU by the user's wish
OTHERS = {
    "features": ({"NUMBA_ENABLE_AVX": "0"}, ""),
    "settings": ({"NUMBA_BOUNDSCHECK": "1"}, ""),
    "numpy": ({}, "import numba, numpy; numpy.__version__ = '1.99.1'\n"),
    "wish": ({"NUMBA_CPU_NAME": "x86-64"}, ""),
}


@pytest.mark.parametrize("other", OTHERS)
def test_code_of_a_wheel_is_for_the_cpus_settings_and_numpy_that_it_was_made_for(wheel, other):
    environment, before = OTHERS[other]
    assert wheel.run(script=before + RUN, **environment) == [9, 0]
    assert wheel.run() == [9, 1]


@pytest.mark.slow
def test_processes_that_compile_at_once_leave_a_sound_cache(package):
    calls = {"1, 2": 9, "1.5, 2": 10.5, "1, 2.5": 10.5}
    with ThreadPoolExecutor(3) as pool:
        assert [value for value, _ in pool.map(package.run, calls)] == list(calls.values())
    assert [package.run(call)[0] for call in calls] == list(calls.values())


# three processes that call the kernel at the same moment
TOGETHER = """
import os, time
from pathlib import Path
from craftmesh.kernels.caller import scaled_sum
Path(f"ready-{{os.getpid()}}").touch()
while len(list(Path().glob("ready-*"))) < 3:
    time.sleep(0.01)
print(scaled_sum({arguments}), sum(scaled_sum.stats.cache_hits.values()))
"""


@pytest.mark.slow
def test_processes_that_start_together_compile_a_kernel_once(package):
    with ThreadPoolExecutor(3) as pool:
        said = list(pool.map(lambda call: package.run(call, TOGETHER), ["1, 2"] * 3))
    assert sorted(said) == [[9, 0], [9, 1], [9, 1]]
    assert len(package.files()) == 2, "one index and one compilation of the kernel that Python calls"


CONSTANTS = """
from numba.core.event import install_recorder
from craftmesh.jit import kernel
from craftmesh.kernels.callee import scaled

@kernel
def scaled_constants():
    return scaled(1) + scaled(2) + scaled(True)

with install_recorder("numba:compile") as compiled:
    print(scaled_constants())
print(sum(one.is_start and one.data["dispatcher"].py_func is scaled.py_func for _, one in compiled.buffer))
"""


def test_constants_do_not_compile_a_kernel_anew(package):
    (package.kernels / "constants.py").write_text(CONSTANTS)
    assert package.run(script="import craftmesh.kernels.constants") == [12, 2]


@pytest.mark.parametrize("module", [name for name in modules() if ".kernels." in name])
def test_the_digest_sees_every_import_of_the_kernels(module):
    found = set(jit.IMPORT.findall(source(module)))
    assert found == imports_of(module)
    assert not any(is_package(name) for name in found), "a kernel takes names from modules"

"""What the start of a verb does not load: libraries that few of its calls need."""

import re
import subprocess
import sys
from pathlib import Path

SNAKEFILE = Path(__file__).resolve().parents[2] / "workflow" / "Snakefile"
HEAVY = {
    "scipy.spatial",
    "scipy.interpolate",
    "scipy.ndimage",
    "scipy.optimize",
    "scipy.sparse.csgraph",
    "scipy.sparse.linalg",
    "scipy.fft",
    "trimesh",
    "PIL",
    "matplotlib",
}
VERBS = (
    "init plan generate import remesh crack size stitch gradate tetrahedralize assemble renew check".split()
)
VERBS += "inp solve fracture grow".split()
LOAD = """
import sys
from craftmesh.cli import load
for verb in {verbs}:
    load(verb)
print(*sys.modules)
"""


def loaded(*verbs: str) -> set[str]:
    command = [sys.executable, "-c", LOAD.format(verbs=verbs)]
    return set(subprocess.run(command, capture_output=True, text=True, check=True).stdout.split())


def test_the_stages_of_an_increment_start_without_libraries_that_few_calls_need():
    found = loaded(*VERBS)
    assert {"numba", "scipy.sparse", "shapely"} <= found
    assert found & HEAVY == set()


def test_the_face_alone_loads_no_numbers():
    assert loaded() & {"numpy", "numba", "scipy", "ast"} == set()


def test_verbs_that_read_files_alone_start_without_kernels():
    assert loaded("check") & {"numba", "scipy"} == set()


def test_a_campaign_starts_without_libraries_that_its_stages_need():
    lines = re.findall(r"^ +(from craftmesh\S* import .+)", SNAKEFILE.read_text(), re.M)
    assert len(lines) > 10
    command = [sys.executable, "-c", "\n".join(["import sys", *lines, "print(*sys.modules)"])]
    found = set(subprocess.run(command, capture_output=True, text=True, check=True).stdout.split())
    assert found & HEAVY == set()

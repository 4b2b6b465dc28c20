"""The memory of remeshing, by a limit on the process in which it runs."""

import subprocess
import sys

import pytest

# Bytes a facet of the surface, beyond Python and kernels: 230,708 facets took under 250 each.
PER_FACET = 300
REMESH = """
import resource
from pathlib import Path
from models import voronoi
from craftmesh.remeshing.remesh import remesh

few, many = voronoi(1, 4, (12,) * 3), voronoi(1, 60, (72,) * 3)
remesh(few)  # compiles and loads all kernels
taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (taken + {per_facet} * {facets},) * 2)
print(len(remesh(many)[0].facets))
"""
FACETS = 230_000


@pytest.mark.slow
def test_a_facet_takes_so_many_bytes_at_most(pytestconfig):
    script = REMESH.format(per_facet=PER_FACET, facets=FACETS)
    done = subprocess.run(
        [sys.executable, "-c", script],
        env={"PYTHONPATH": str(pytestconfig.rootpath / "tests")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stderr == "" and int(done.stdout) >= FACETS

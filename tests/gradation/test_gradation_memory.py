"""The memory of a gradation: the peak of the process in which it runs."""

import subprocess
import sys

import pytest
from models import voronoi

from craftmesh.io.vtk import write_surface
from craftmesh.remeshing.remesh import RemeshOptions, remesh

# Bytes a facet read, beyond Python and kernels.
PER_FACET = 450
GRADATE = """
import sys
import numpy as np
from craftmesh import Sizing, gradate
from craftmesh.io.vtk import read_surface

sizing = Sizing(1.0, 1.0, 3.0, 8.0, 16.0, 1.0, np.array([[36.0, y, 36.0] for y in range(72)]))

def memory(name):
    status = open("/proc/self/status").read()
    return 1024 * int(status.split(name + ":")[1].split()[0])

def gradated(path):
    surface = read_surface(path)
    assert len(gradate(surface, sizing)[0].facets) < len(surface.facets)

gradated(sys.argv[1])  # compiles and loads all kernels
open("/proc/self/clear_refs", "w").write("5")  # the peak begins anew
before = memory("VmRSS")
gradated(sys.argv[2])
print(memory("VmHWM") - before)
"""


@pytest.mark.slow
def test_a_facet_takes_so_many_bytes_at_most(tmp_path):
    paths = []
    for name, n, edge in (("few", 4, 12), ("many", 60, 72)):
        surface = remesh(voronoi(1, n, (edge,) * 3), RemeshOptions(taubin_laps=2))[0]
        paths.append(tmp_path / f"{name}.vtp")
        write_surface(paths[-1], surface)
    words = [sys.executable, "-c", GRADATE, *paths]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    count = len(surface.facets)
    assert count > 150_000
    assert int(done.stdout) < PER_FACET * count

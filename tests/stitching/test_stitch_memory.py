"""The memory of stitching, by a limit on the process in which it runs."""

import subprocess
import sys

import pytest
from grain_folders import write_grain_folder
from models import voronoi

from craftmesh.remeshing.remesh import RemeshOptions, remesh

# Bytes a facet of the stitched surface, beyond Python and kernels: 433,000 facets took 350 each.
PER_FACET = 450
STITCH = """
import resource, sys
from pathlib import Path
from craftmesh.io.surface_files import read_grain_folder
from craftmesh.stitching.stitch import stitch_grains

def stitched(folder):
    return len(stitch_grains(read_grain_folder(folder))[0].facets)

few = stitched(sys.argv[1])  # compiles and loads all kernels
taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (taken + int(sys.argv[3]),) * 2)
print(stitched(sys.argv[2]))
"""


@pytest.mark.slow
def test_a_facet_takes_so_many_bytes_at_most(tmp_path):
    surfaces = [
        remesh(voronoi(1, n, (edge,) * 3), RemeshOptions(taubin_laps=2))[0]
        for n, edge in ((4, 12), (60, 72))
    ]
    for name, surface in zip(("few", "many"), surfaces):
        write_grain_folder(tmp_path / name, surface)
    count = len(surfaces[1].facets)
    assert count > 150_000
    done = subprocess.run(
        [sys.executable, "-c", STITCH, tmp_path / "few", tmp_path / "many", str(PER_FACET * count)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.stdout.strip(), done.stderr) == (str(count), "")

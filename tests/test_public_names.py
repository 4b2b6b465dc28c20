"""The package's public names: found by type checkers and TAB alike, imported at their first use."""

import subprocess
import sys

import numpy as np
import pytest
from structured_box import structured_box

import craftmesh
from craftmesh.voxels.generate import generate

BOX = ", from [0.0, 0.0, 0.0] to [2.0, 2.0, 2.0]"


@pytest.mark.parametrize("name", craftmesh.__all__)
def test_a_name_is_what_its_module_has(name):
    found = getattr(craftmesh, name)
    assert found.__name__ == name and name in dir(craftmesh)


def test_the_stub_has_every_public_name_once_and_nothing_else():
    lines = [line for line in craftmesh._STUB.splitlines() if line and not line.startswith('"""')]
    assert lines.pop() == "__version__: str"
    assert len(lines) == len(craftmesh.__all__), "a line that is not `from module import name as name`"


def test_the_version_is_the_installed_one_and_other_names_are_none():
    assert craftmesh.__version__.count(".") == 2
    with pytest.raises(AttributeError, match="'craftmesh' has no attribute 'remsh'"):
        _ = craftmesh.remsh  # type: ignore[attr-defined]


def test_importing_the_package_imports_no_library():
    code = "import sys, craftmesh; print({'numpy', 'numba', 'scipy', 'vtk'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


def test_things_say_what_they_are_in_one_line():
    voxels = generate()
    shape = " x ".join(map(str, voxels.labels.shape))
    assert repr(voxels).startswith(f"Voxels({shape}, spacing [1.0, 1.0, 1.0], ")
    assert repr(voxels).endswith(f", from {voxels.box[0].tolist()} to {voxels.box[1].tolist()})")
    surface, grain_tets = structured_box((2, 2, 2), lambda centres: 1 + (centres[:, 0] > 1))
    assert repr(surface) == f"Surface({len(surface.facets)} facets, 27 points, 2 grains{BOX})"
    mesh, _ = craftmesh.assemble(surface, grain_tets)
    faces = "XMIN, XMAX, YMIN, YMAX, ZMIN, ZMAX"
    assert repr(mesh) == f"TetMesh({len(mesh.tets)} tets of 4 nodes, 27 points, 2 grains, {faces}{BOX})"
    crack = craftmesh.Crack(np.eye(3), [[0, 1, 2]], ())
    box = "from [0.0, 0.0, 0.0] to [1.0, 1.0, 1.0]"
    assert repr(crack) == f"Crack(1 triangles, 3 points, no front, {box})"
    tets = grain_tets[0]
    counts = f"{len(tets.tets)} tets, {len(tets.nodes)} surface points, 0 interior points"
    assert repr(tets) == f"GrainTets(grain 1, {counts})"

"""Versions of the programs that the meshes come from."""

import platform
from importlib.metadata import PackageNotFoundError, version

PACKAGES = ("craftmesh", "tetgen", "pytetwild", "numpy", "scipy", "numba", "pyamg", "vtk", "snakemake")


def versions() -> dict[str, str]:
    """Return the versions of craftmesh, Python and what the meshes depend on, by name."""
    found = {}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return {"python": platform.python_version(), **found}

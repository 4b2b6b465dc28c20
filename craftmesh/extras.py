"""The door to packages that an extra of craftmesh brings: one that is missing is named in one line."""

from collections.abc import Iterator
from contextlib import contextmanager

from craftmesh.errors import CraftmeshError

# Packages that are imported under another name.
_PACKAGES = {"nrrd": "pynrrd", "PIL": "pillow"}


@contextmanager
def extra(name: str) -> Iterator[None]:
    """Import within this what the extra `name` brings; raise CraftmeshError if a package is missing."""
    try:
        yield
    except ModuleNotFoundError as error:
        module = str(error.name).partition(".")[0]
        raise CraftmeshError(
            f"the package {_PACKAGES.get(module, module)} is not installed; get the extra {name}: "
            f"pip install 'craftmesh[{name}]'"
        ) from None

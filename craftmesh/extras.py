"""Import of optional packages: a missing package gives a one-line error that names the extra to install."""

from collections.abc import Iterator
from contextlib import contextmanager

from craftmesh.errors import CraftmeshError

# Name of a package on the index by its import name, where the two differ.
_PACKAGES = {"nrrd": "pynrrd", "PIL": "pillow"}


@contextmanager
def extra(name: str) -> Iterator[None]:
    """Raise CraftmeshError with the command to install the extra `name` if an import in the block fails.

    Only ModuleNotFoundError is converted.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        module = str(error.name).partition(".")[0]
        raise CraftmeshError(
            f"the package {_PACKAGES.get(module, module)} is not installed; get the extra {name}: "
            f"pip install 'craftmesh[{name}]'"
        ) from None

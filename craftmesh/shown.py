"""Pictures of things in notebooks; `report/notebook` draws them when they are asked for."""

from importlib import import_module
from typing import Any


class Shown:
    """Base of types with a picture: `.plot()` shows it.

    A notebook cell that ends with the object shows the object's line of text and the picture below it.
    """

    def plot(self, **options: Any) -> Any:
        """Show the thing with pyvista, which takes the options; without pyvista return a picture.

        Raises CraftmeshError if neither pyvista nor the extra `pictures` is installed.
        """
        return import_module("craftmesh.report.notebook").plot(self, **options)

    def _repr_html_(self) -> str:
        return import_module("craftmesh.report.notebook").html(self)

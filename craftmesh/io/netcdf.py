"""Files in NetCDF's classic format with 64-bit offsets (CDF-2), which every NetCDF library reads."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from craftmesh.atomic import atomic_path
from craftmesh.errors import CraftmeshError

# scipy sorts variables by the shape that they are made with, and does nothing else with it but to tell
# record variables. Given one shape they keep their order, by which meshio names the sets of an Exodus file.
_ANY_LENGTH = (1,)
LARGEST = 2**31 - 4  # bytes of a variable: scipy packs its padded size as int32


@dataclass(frozen=True)
class Variable:
    """An array over named dimensions; int32, float32, float64 or single characters."""

    name: str
    dimensions: tuple[str, ...]
    values: np.ndarray
    attributes: Mapping[str, str] = field(default_factory=dict)


def write_netcdf(
    path: str | os.PathLike,
    dimensions: Mapping[str, int | None],
    variables: Sequence[Variable],
    attributes: Mapping[str, object],
) -> None:
    """Write the file whole or not at all; the same input gives the same bytes.

    dimensions: name -> length > 0, None for the record dimension, the first, of which there is one record.
    Variables that have it, as their first dimension, come last in `variables`, whose order the file keeps.
    Attributes are texts or numbers. Raises CraftmeshError, before anything is written, for a variable of
    over 2 GiB.
    """
    from scipy.io import netcdf_file, netcdf_variable

    for variable in variables:
        if variable.values.nbytes > LARGEST:
            raise CraftmeshError(
                f"{path}: {variable.name} takes {variable.values.nbytes} bytes; NetCDF by scipy has up to "
                f"{LARGEST}: export to .vtu instead, or coarsen the mesh"
            )
    with atomic_path(path) as temporary, netcdf_file(temporary, "w", version=2) as file:
        for name, length in dimensions.items():
            file.createDimension(name, length)
        for name, value in attributes.items():
            setattr(file, name, value)
        for variable in variables:
            data = np.ascontiguousarray(variable.values, variable.values.dtype.newbyteorder(">"))
            is_record = dimensions[variable.dimensions[0]] is None
            file.variables[variable.name] = netcdf_variable(
                data,
                data.dtype.char,
                data.dtype.itemsize,
                (None,) if is_record else _ANY_LENGTH,
                variable.dimensions,
                dict(variable.attributes),
            )

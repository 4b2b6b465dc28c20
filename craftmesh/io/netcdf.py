"""Files in NetCDF's classic format with 64-bit offsets (CDF-2), which every NetCDF library reads."""

import os
import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from craftmesh.atomic import atomic_path

_DIMENSIONS, _VARIABLES, _ATTRIBUTES = 10, 11, 12
_TYPES = {"S1": 2, ">i4": 4, ">f4": 5, ">f8": 6}


@dataclass(frozen=True)
class Variable:
    """An array over named dimensions; int32, float32, float64 or single characters."""

    name: str
    dimensions: tuple[str, ...]
    values: np.ndarray
    attributes: Mapping[str, object] = field(default_factory=dict)

    @property
    def kind(self) -> str:
        """The type in the file, big-endian."""
        return "S1" if self.values.dtype.kind == "S" else self.values.dtype.newbyteorder(">").str


def write_netcdf(
    path: str | os.PathLike,
    dimensions: Mapping[str, int | None],
    variables: Sequence[Variable],
    attributes: Mapping[str, object],
) -> None:
    """Write the file whole or not at all; the same input gives the same bytes.

    dimensions: name -> length > 0, None for the record dimension, of which there is one record. Variables
    that have it, as their first dimension, come last in `variables`. Attributes are texts or numbers.
    """
    ids = {name: number for number, name in enumerate(dimensions)}
    starts = [0] * len(variables)
    start = len(b"".join(_header(dimensions, ids, variables, attributes, starts)))
    for place, variable in enumerate(variables):
        starts[place] = start
        start += _padded(variable.values.nbytes)
    with atomic_path(path) as temporary, open(temporary, "wb") as stream:
        stream.writelines(_header(dimensions, ids, variables, attributes, starts))
        for variable in variables:
            stream.write(np.ascontiguousarray(variable.values, variable.kind).data)
            stream.write(bytes(_padded(variable.values.nbytes) - variable.values.nbytes))


def _header(dimensions, ids, variables, attributes, starts) -> Iterator[bytes]:
    yield b"CDF\x02" + struct.pack(">i", 1)
    yield struct.pack(">ii", _DIMENSIONS, len(dimensions))
    for name, length in dimensions.items():
        yield _name(name) + struct.pack(">i", length or 0)
    yield from _attribute_list(attributes)
    yield struct.pack(">ii", _VARIABLES, len(variables))
    for variable, start in zip(variables, starts):
        yield _name(variable.name) + struct.pack(">i", len(variable.dimensions))
        yield b"".join(struct.pack(">i", ids[name]) for name in variable.dimensions)
        yield from _attribute_list(variable.attributes)
        yield struct.pack(">iIq", _TYPES[variable.kind], _padded(variable.values.nbytes), start)


def _attribute_list(attributes: Mapping[str, object]) -> Iterator[bytes]:
    yield struct.pack(">ii", _ATTRIBUTES if attributes else 0, len(attributes))
    for name, value in attributes.items():
        if isinstance(value, str):
            data, kind, count = value.encode("ascii"), "S1", len(value)
        else:
            number = np.asarray(value)
            kind, count = number.dtype.newbyteorder(">").str, 1
            data = number.astype(kind).tobytes()
        yield _name(name) + struct.pack(">ii", _TYPES[kind], count) + _filled(data)


def _name(name: str) -> bytes:
    return struct.pack(">i", len(name)) + _filled(name.encode("ascii"))


def _filled(data: bytes) -> bytes:
    return data + bytes(_padded(len(data)) - len(data))


def _padded(size: int) -> int:
    return -(-size // 4) * 4

"""What callers hand to the library, checked before anything is cast: arrays, and craftmesh's own types."""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import wraps
from types import MappingProxyType
from typing import Any, TypeVar, cast, get_args, get_origin

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from craftmesh.errors import CraftmeshError
from craftmesh.options import alternatives

Function = TypeVar("Function", bound=Callable)

LARGEST = 1e100  # of a coordinate or length: the volume, its cube, is still a float


def as_array(
    name: str, value: ArrayLike, dtype: DTypeLike, shape: tuple, *, finite: bool = True
) -> np.ndarray:
    """Return `value` as a read-only C-contiguous copy of `dtype`; None in `shape` admits any length.

    Whole numbers may be given as floats such as 3.0. Raises CraftmeshError for what is no array of numbers
    (truth values, text, other libraries' objects), another shape, numbers that `dtype` does not hold
    without loss, and, unless `finite` is False, floats that are not finite or over LARGEST.
    """
    whole = np.dtype(dtype).kind in "iu"
    lengths = ", ".join("n" if length is None else str(length) for length in shape)
    wanted = f"an array ({lengths}) of {'whole ' if whole else ''}numbers"
    try:
        given = np.asarray(value)
    except (TypeError, ValueError):
        raise CraftmeshError(f"{name} has rows of unlike lengths; expected {wanted}") from None
    if given.dtype.kind not in "iuf" or np.ma.is_masked(value):
        what = f"a {type(value).__name__}" if not isinstance(value, (list, tuple, np.ndarray)) else None
        raise CraftmeshError(f"{name} is {what or f'an array of {given.dtype}'}; expected {wanted}")
    if given.shape == (0,) and shape[:1] == (None,):  # []: none, of whatever shape
        given = given.reshape([length or 0 for length in shape])
    if given.ndim != len(shape) or any(s is not None and s != n for s, n in zip(shape, given.shape)):
        raise CraftmeshError(f"{name} has shape {given.shape}; expected ({lengths})")
    if whole and not np.can_cast(given.dtype, dtype) and given.size:
        _refuse_lossy(name, given, np.iinfo(dtype))  # type: ignore[arg-type]  # it is whole
    array = np.array(given, dtype=dtype, order="C")
    if finite and not whole and not (held := np.abs(array) <= LARGEST).all():
        place = tuple(np.argwhere(~held)[0].tolist())
        wanted = "finite numbers" + f" up to {LARGEST:g}" * bool(np.isfinite(array[place]))
        raise CraftmeshError(f"{name}{list(place) or ''} is {array[place]}; expected {wanted}")
    array.flags.writeable = False
    return array


def _refuse_lossy(name: str, given: np.ndarray, limits: np.iinfo) -> None:
    """Raise CraftmeshError unless numbers are whole and within the limits of a type."""
    if given.dtype.kind == "f":
        with np.errstate(invalid="ignore"):
            broken = given % 1 != 0  # nan and inf too
        if broken.any():
            raise CraftmeshError(f"{name} holds {given[broken][0]}; expected whole numbers")
    low, high = given.min(), given.max()
    if low < limits.min or high > limits.max:
        found = low if low < limits.min else high
        raise CraftmeshError(f"{name} holds {found}; expected whole numbers {limits.min} to {limits.max}")


class Frozen:
    """Base of frozen dataclasses of arrays: the constructor makes copies too, so they stay read-only."""

    def __reduce__(self) -> tuple[type, tuple]:
        values = (getattr(self, item.name) for item in fields(cast(Any, self)))
        return type(self), tuple(dict(one) if isinstance(one, MappingProxyType) else one for one in values)

    def _convert(self, name: str, dtype: DTypeLike, shape: tuple, *, finite: bool = True) -> None:
        """Replace a field by a checked, read-only array, see `as_array`."""
        array = as_array(f"{type(self).__name__}.{name}", getattr(self, name), dtype, shape, finite=finite)
        object.__setattr__(self, name, array)

    def _convert_mapping(self, name: str) -> None:
        """Replace a field by a read-only copy of the mapping that it is."""
        value = getattr(self, name)
        refuse_others(f"{type(self).__name__}.{name}", value, (Mapping,))
        object.__setattr__(self, name, MappingProxyType(dict(value)))


def check_indices(name: str, indices: np.ndarray, count: int, of: str = "points") -> None:
    """Raise CraftmeshError unless all indices are of `count` things."""
    if indices.size and (indices.min() < 0 or indices.max() >= count):
        raise CraftmeshError(
            f"{name} refers to {of} {indices.min()}..{indices.max()}; there are {count} {of}, from 0"
        )


def typed(function: Function) -> Function:
    """Return `function`, refusing arguments that are not of the classes in its signature.

    Arrays, and what iterables hold that are no lists or tuples, are the function's own matter. Raises
    CraftmeshError.
    """
    signature = inspect.signature(function)

    @wraps(function)
    def checked(*args: Any, **kwargs: Any) -> Any:
        for name, value in signature.bind(*args, **kwargs).arguments.items():
            refuse_unlike(f"{function.__name__}: {name}", value, signature.parameters[name].annotation)
        return function(*args, **kwargs)

    return cast(Function, checked)


def refuse_others(name: str, value: object, classes: tuple[type, ...]) -> None:
    """Raise CraftmeshError unless `value` is of one of the classes; none admit everything."""
    if classes and not isinstance(value, classes):
        wanted = " or ".join("None" if kind is type(None) else kind.__name__ for kind in classes)
        raise CraftmeshError(f"{name} is a {type(value).__name__}; expected {wanted}")


def refuse_unlike(name: str, value: object, hint: Any) -> None:
    """Raise CraftmeshError unless `value`, and what a list or tuple holds, is of the hint's classes."""
    parts = alternatives(hint)
    classes = tuple(get_origin(part) or part for part in parts)
    if any(not isinstance(kind, type) or kind in (np.ndarray, Any) for kind in classes):
        return
    refuse_others(name, value, classes)
    items = get_args(parts[0]) if isinstance(value, (list, tuple, str)) else ()
    if len(items) == 1 or items[1:] == (Ellipsis,):
        for place, item in enumerate(cast(list, value)):
            refuse_unlike(f"{name}[{place}]", item, items[0])
    elif items and len(items) != len(cast(tuple, value)):
        raise CraftmeshError(f"{name} has {len(cast(tuple, value))} items; expected {len(items)}")

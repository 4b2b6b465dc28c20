"""Checks of what callers pass to the library, before any conversion: arrays and craftmesh's own types."""

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

LARGEST = 1e100  # largest coordinate or length; its cube, a volume, is still a finite float


def as_array(
    name: str, value: ArrayLike, dtype: DTypeLike, shape: tuple, *, finite: bool = True
) -> np.ndarray:
    """Return `value` as a read-only C-contiguous array of `dtype`; None in `shape` allows any length.

    The array is a copy, unless `value` is such an array and owns its data.

    Integers may be given as floats such as 3.0, and [] stands for an array without rows. Raises
    CraftmeshError if `value` is not an array of numbers (booleans, text, masked entries, other libraries'
    objects), has another shape, or, for an integer `dtype`, holds fractions or values out of its range.
    Unless `finite` is False, floats must be finite and at most LARGEST in size.
    """
    whole = np.dtype(dtype).kind in "iu"
    lengths = ", ".join("n" if length is None else str(length) for length in shape)
    wanted = f"an array ({lengths}) of {'whole ' if whole else ''}numbers"
    try:
        given = np.asarray(value)
    except (TypeError, ValueError):
        raise CraftmeshError(f"{name} has rows of different lengths; expected {wanted}") from None
    if given.dtype.kind not in "iuf" or np.ma.is_masked(value):
        what = f"a {type(value).__name__}" if not isinstance(value, (list, tuple, np.ndarray)) else None
        what = "an array with masked entries" if np.ma.is_masked(value) else what
        raise CraftmeshError(f"{name} is {what or f'an array of {given.dtype}'}; expected {wanted}")
    if given.shape == (0,) and shape[:1] == (None,):  # [] stands for no rows of any shape
        given = given.reshape([length or 0 for length in shape])
    if given.ndim != len(shape) or any(s is not None and s != n for s, n in zip(shape, given.shape)):
        raise CraftmeshError(f"{name} has shape {given.shape}; expected ({lengths})")
    if whole and not np.can_cast(given.dtype, dtype) and given.size:
        _refuse_lossy(name, given, np.iinfo(dtype))  # type: ignore[arg-type]  # an integer type, as checked
    flags = given.flags
    is_kept = given.dtype == dtype and flags.c_contiguous and flags.owndata and not flags.writeable
    array = given if is_kept else np.array(given, dtype=dtype, order="C")
    if finite and not whole and not (held := np.abs(array) <= LARGEST).all():
        place = tuple(np.argwhere(~held)[0].tolist())
        wanted = "finite numbers" + f" up to {LARGEST:g}" * bool(np.isfinite(array[place]))
        raise CraftmeshError(f"{name}{list(place) or ''} is {array[place]}; expected {wanted}")
    array.flags.writeable = False
    return array


def _refuse_lossy(name: str, given: np.ndarray, limits: np.iinfo) -> None:
    """Raise CraftmeshError unless all numbers `given` are integers within the `limits` of a dtype."""
    if given.dtype.kind == "f":
        with np.errstate(invalid="ignore"):
            broken = given % 1 != 0  # True for nan and inf too
        if broken.any():
            raise CraftmeshError(f"{name} holds {given[broken][0]}; expected whole numbers")
    low, high = given.min(), given.max()
    if low < limits.min or high > limits.max:
        found = low if low < limits.min else high
        raise CraftmeshError(f"{name} holds {found}; expected whole numbers {limits.min} to {limits.max}")


class Frozen:
    """Base of frozen dataclasses of arrays: the constructor copies arrays that can be written to."""

    def __reduce__(self) -> tuple[type, tuple]:
        values = (getattr(self, item.name) for item in fields(cast(Any, self)))
        return type(self), tuple(dict(one) if isinstance(one, MappingProxyType) else one for one in values)

    def _convert(self, name: str, dtype: DTypeLike, shape: tuple, *, finite: bool = True) -> None:
        """Replace the array field `name` by a checked, read-only array; parameters as in `as_array`."""
        array = as_array(f"{type(self).__name__}.{name}", getattr(self, name), dtype, shape, finite=finite)
        object.__setattr__(self, name, array)

    def _convert_mapping(self, name: str) -> None:
        """Replace the field `name` by a read-only copy; raise CraftmeshError if it is no mapping."""
        value = getattr(self, name)
        refuse_others(f"{type(self).__name__}.{name}", value, (Mapping,))
        object.__setattr__(self, name, MappingProxyType(dict(value)))


def check_indices(name: str, indices: np.ndarray, count: int, of: str = "points") -> None:
    """Raise CraftmeshError unless all indices are in 0 ... count - 1; `of` names what they point to."""
    if indices.size and (indices.min() < 0 or indices.max() >= count):
        raise CraftmeshError(
            f"{name} refers to {of} {indices.min()}..{indices.max()}; there are {count} {of}, ids from 0"
        )


def typed(function: Function) -> Function:
    """Return `function` wrapped to check its arguments against the classes in its signature.

    The wrapper raises CraftmeshError for an argument of another class. Not checked: arrays, and the items
    of iterables other than lists and tuples.
    """
    signature = inspect.signature(function)

    @wraps(function)
    def checked(*args: Any, **kwargs: Any) -> Any:
        for name, value in signature.bind(*args, **kwargs).arguments.items():
            refuse_unlike(f"{function.__name__}: {name}", value, signature.parameters[name].annotation)
        return function(*args, **kwargs)

    return cast(Function, checked)


def refuse_others(name: str, value: object, classes: tuple[type, ...]) -> None:
    """Raise CraftmeshError unless `value` is of one of the classes; an empty tuple allows any value."""
    if classes and not isinstance(value, classes):
        wanted = " or ".join("None" if kind is type(None) else kind.__name__ for kind in classes)
        raise CraftmeshError(f"{name} is a {type(value).__name__}; expected {wanted}")


def refuse_unlike(name: str, value: object, hint: Any) -> None:
    """Raise CraftmeshError unless `value`, and each item of a list or tuple, is of a class of `hint`.

    Not checked: hints that allow an array or Any.
    """
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

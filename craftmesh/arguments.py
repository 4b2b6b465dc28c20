"""What callers hand to the library, checked before anything is cast: arrays, and craftmesh's own types."""

import inspect
from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from craftmesh.errors import CraftmeshError
from craftmesh.options import alternatives

Function = TypeVar("Function", bound=Callable)


def as_array(
    name: str, value: ArrayLike, dtype: DTypeLike, shape: tuple, *, finite: bool = True
) -> np.ndarray:
    """Return `value` as a read-only C-contiguous copy of `dtype`; None in `shape` admits any length.

    Whole numbers may be given as floats such as 3.0. Raises CraftmeshError for what is no array of numbers
    (truth values, text, other libraries' objects), another shape, numbers that `dtype` does not hold
    without loss, and, unless `finite` is False, floats that are not finite.
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
    if given.ndim != len(shape) or any(s is not None and s != n for s, n in zip(shape, given.shape)):
        raise CraftmeshError(f"{name} has shape {given.shape}; expected ({lengths})")
    if whole and not np.can_cast(given.dtype, dtype) and given.size:
        _refuse_lossy(name, given, np.iinfo(dtype))  # type: ignore[arg-type]  # it is whole
    array = np.array(given, dtype=dtype, order="C")
    if finite and not whole and not np.isfinite(array).all():
        place = tuple(np.argwhere(~np.isfinite(array))[0].tolist())
        raise CraftmeshError(f"{name}{list(place)} is {array[place]}; expected finite numbers")
    array.flags.writeable = False
    return array


def _refuse_lossy(name: str, given: np.ndarray, limits: np.iinfo) -> None:
    """Raise CraftmeshError unless numbers are whole and within the limits of a type."""
    if given.dtype.kind == "f":
        with np.errstate(invalid="ignore"):
            broken = given % 1 != 0  # nan and inf too
        if broken.any():
            raise CraftmeshError(f"{name} holds {given[broken][0]}; expected whole numbers")
    low, high = int(given.min()), int(given.max())
    if low < limits.min or high > limits.max:
        found = low if low < limits.min else high
        raise CraftmeshError(f"{name} holds {found}; expected whole numbers {limits.min} to {limits.max}")


def check_indices(name: str, indices: np.ndarray, count: int, of: str = "points") -> None:
    """Raise CraftmeshError unless all indices are of `count` things."""
    if indices.size and (indices.min() < 0 or indices.max() >= count):
        raise CraftmeshError(
            f"{name} refers to {of} {indices.min()}..{indices.max()}; there are {count} {of}, from 0"
        )


def typed(function: Function) -> Function:
    """Return `function`, refusing arguments that are not of the classes in its signature.

    Arrays and generic types are the function's own matter. Raises CraftmeshError.
    """
    signature = inspect.signature(function)
    classes = {name: _classes(item.annotation) for name, item in signature.parameters.items()}

    @wraps(function)
    def checked(*args: Any, **kwargs: Any) -> Any:
        for name, value in signature.bind(*args, **kwargs).arguments.items():
            refuse_others(f"{function.__name__}: {name}", value, classes[name])
        return function(*args, **kwargs)

    return cast(Function, checked)


def refuse_others(name: str, value: object, classes: tuple[type, ...]) -> None:
    """Raise CraftmeshError unless `value` is of one of the classes; none admit everything."""
    if classes and not isinstance(value, classes):
        wanted = " or ".join("None" if kind is type(None) else kind.__name__ for kind in classes)
        raise CraftmeshError(f"{name} is a {type(value).__name__}; expected {wanted}")


def _classes(hint: Any) -> tuple[type, ...]:
    parts = alternatives(hint)
    plain = all(isinstance(part, type) and part is not np.ndarray for part in parts)
    return parts if plain else ()

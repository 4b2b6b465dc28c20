"""Loads and supports of the box's faces as rows such as "ZMAX.x=stress:30"; load cases and their sums."""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.types import BOX_PLANES

RESIDUAL = "residual_stress"  # name of the load case of the residual stress
FIXED, STRAIN, STRESS = "fixed", "strain", "stress"
_EXPECTED = (
    f"expected FACE.AXIS={FIXED}, FACE.AXIS={STRAIN}:VALUE or FACE.AXIS={STRESS}:VALUE, with a FACE of "
    f"{', '.join(BOX_PLANES)} and an AXIS of x, y, z, or AXIS={STRESS}:VALUE for a tension; CASE/ in "
    "front names a load case"
)
_NAME = re.compile(r"[A-Za-z]\w*", re.ASCII)


class FaceRow(NamedTuple):
    """The load or support of a plane of the box along an axis (0, 1, 2), normal to the plane or in it.

    kind: FIXED, no displacement; STRAIN, a displacement relative to the box's length normal to the plane;
    or STRESS, a component of the stress. Positive values point along the axis on MAX planes and against it
    on MIN planes, as the traction of a stress does, so the same value on both is a uniform tension or
    shear. case: the load case of the row, "" for all load cases.
    """

    plane: str
    axis: int
    kind: str
    value: float = 0.0
    case: str = ""

    @property
    def across(self) -> int:
        """The axis (0, 1, 2) normal to the plane."""
        return "XYZ".index(self.plane[0])

    @property
    def along(self) -> float:
        """The value counted along the axis: its sign is reversed on MIN planes."""
        return self.value if self.plane.endswith("MAX") else -self.value


def parse_faces(texts: Iterable[str]) -> tuple[FaceRow, ...]:
    """Return the rows that texts such as "ZMAX.x=stress:30" describe; "z=stress:30" describes two.

    Raises CraftmeshError for texts of another form and for strains over 1 in magnitude.
    """
    return tuple(row for text in texts for row in _rows(text))


def _rows(text: str) -> list[FaceRow]:
    """Return the row of a text; if it names only an axis, rows of the fixed MIN and the loaded MAX face."""
    place, _, what = text.partition("=")
    case, _, place = (part.strip() for part in place.rpartition("/"))
    is_tension = place in ("x", "y", "z")
    plane, _, axis = (f"{place}max", "", place) if is_tension else place.partition(".")
    kind, _, value = (part.strip() for part in what.partition(":"))
    number = number_of(value)
    is_kind = number is not None if kind in (STRAIN, STRESS) else what.strip() == FIXED
    if plane.upper() not in BOX_PLANES or axis not in ("x", "y", "z") or not is_kind:
        raise CraftmeshError(f"faces: {text!r}; {_EXPECTED}")
    if kind == STRAIN and abs(number or 0.0) > 1:
        raise CraftmeshError(
            f"faces: {text!r} moves the face by more than the body's length; expected a small strain such "
            "as 0.001"
        )
    row = FaceRow(plane.upper(), "xyz".index(axis), kind, number or 0.0, case)
    return [row._replace(plane=f"{plane[0].upper()}MIN", kind=FIXED, value=0.0), row][not is_tension :]


def number_of(text: str) -> float | None:
    """Return the finite number in a text, None for any other text."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def named_numbers(texts: Sequence[str], mark: str = "=") -> dict[str, float] | None:
    """Return numbers by name from texts NAME=NUMBER; `mark` is the sign between name and number.

    None if a value is not a finite number or a name is duplicate.
    """
    pairs = [text.partition(mark) for text in texts]
    numbers = {name.strip(): number_of(value) for name, _, value in pairs}
    known = {name: value for name, value in numbers.items() if value is not None}
    return known if len(known) == len(pairs) else None


class Combination(NamedTuple):
    """A weighted sum of load cases; factors: by load case. A single load case is a sum with factor 1."""

    name: str
    factors: Mapping[str, float]

    def sum_of(self, fields: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return the weighted sum of the load cases' fields; fields: arrays of one shape by load case."""
        return sum((factor * fields[case] for case, factor in self.factors.items()), np.zeros(()))


def rows_of(rows: Iterable[FaceRow], case: str) -> tuple[FaceRow, ...]:
    """Return the rows that act in a load case: its own rows, and rows without a case."""
    return tuple(row for row in rows if row.case in ("", case))


def combinations_of(
    rows: Sequence[FaceRow], cases: Sequence[str], texts: Iterable[str]
) -> tuple[Combination, ...]:
    """Return the combinations of load cases that texts describe; without texts, each load case by itself.

    rows: of all cases; cases: their names; texts such as "sum=a:1,b:0.5". Raises CraftmeshError for invalid
    names and texts, for two rows of one face and axis in a load case, for unknown load cases, and for a sum
    of cases that hold or move different faces.
    """
    for case in cases or [""]:
        places = [(row.plane, row.axis) for row in rows_of(rows, case)]
        for plane, axis in (place for place in places if places.count(place) > 1):
            of_case = f" in load case {case}" if case else ""
            raise CraftmeshError(f"faces: {plane}.{'xyz'[axis]} has several rows{of_case}; keep one")
    found = [_combination(text, cases) for text in texts]
    names = [*cases, *(one.name for one in found)]
    for name, key in zip(names[::-1], ["combine"] * len(found) + ["faces"] * len(cases)):
        if not _NAME.fullmatch(name) or names.count(name) > 1:
            raise CraftmeshError(
                f"{key}: {name!r} is an invalid or duplicate name of a load case or a sum; use a letter, "
                "then letters, digits and _, and each name once"
            )
    for one in found:
        check_supports(f"combine: {one.name} adds", one.factors, rows)
    return tuple(found or [Combination(case, {case: 1.0}) for case in cases])


def _combination(text: str, cases: Sequence[str]) -> Combination:
    name, _, terms = text.partition("=")
    factors = named_numbers(terms.split(","), ":")
    if factors is None:
        raise CraftmeshError(
            f"combine: {text!r}; expected NAME=CASE:FACTOR,CASE:FACTOR,... with each load case once"
        )
    for case in factors:
        if case not in cases:
            known = ", ".join(cases) or "none: name them by CASE/ before rows of faces"
            raise CraftmeshError(f"combine: {text!r} has load case {case!r}; expected one of {known}")
    return Combination(name.strip(), factors)


def check_supports(what: str, cases: Iterable[str], rows: Sequence[FaceRow]) -> None:
    """Raise CraftmeshError if the cases of a sum or a load history hold or move different faces.

    Their sum would have the supports of none of them. The residual stress takes the supports of the other
    cases. what: the words before the names of the cases in the error.
    """
    held = {
        case: {f"{row.plane}.{'xyz'[row.axis]}" for row in rows_of(rows, case) if row.kind != STRESS}
        for case in cases
        if case != RESIDUAL
    }
    first, *others = held or [""]
    for case in others:
        if apart := held[first] ^ held[case]:
            raise CraftmeshError(
                f"{what} {first} and {case}, but only one of these holds or moves "
                f"{', '.join(sorted(apart))}; fix it in the other too, or give it a stress in both"
            )

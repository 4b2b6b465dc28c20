"""Load cases by name, and sums of them: "peak=tension:1,shear:0.3"."""

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.faces import STRESS, FaceRow, number_of

_NAME = re.compile(r"[A-Za-z]\w*", re.ASCII)


class Combination(NamedTuple):
    """A sum of load cases, each times its factor; a load case counts as one of itself."""

    name: str
    factors: Mapping[str, float]

    def sum_of(self, fields: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return the sum of the load cases' fields, arrays of one shape by name."""
        return sum((factor * fields[case] for case, factor in self.factors.items()), np.zeros(()))


def rows_of(rows: Iterable[FaceRow], case: str) -> tuple[FaceRow, ...]:
    """Return the rows of a load case: its own, and those of all."""
    return tuple(row for row in rows if row.case in ("", case))


def combinations_of(
    rows: Sequence[FaceRow], cases: Sequence[str], texts: Iterable[str]
) -> tuple[Combination, ...]:
    """Return the combinations of load cases that texts name, without any each load case by itself.

    rows: those of all cases. Raises CraftmeshError for names and texts that are none, for two rows of one
    face and axis in a load case, for load cases that are not there, and for a sum of cases that do not hold
    the same.
    """
    for case in cases or [""]:
        _check_once(rows_of(rows, case), case)
    found = [_combination(text, cases) for text in texts]
    names = [*cases, *(one.name for one in found)]
    for name, key in zip(names[::-1], ["combine"] * len(found) + ["faces"] * len(cases)):
        if not _NAME.fullmatch(name) or names.count(name) > 1:
            raise CraftmeshError(
                f"{key}: {name!r} is to name a load case or a sum; expected a letter, then letters, digits "
                "and _, and each name once"
            )
    for one in found:
        check_supports(one.name, one.factors, rows)
    return tuple(found or [Combination(case, {case: 1.0}) for case in cases])


def _combination(text: str, cases: Sequence[str]) -> Combination:
    name, _, terms = text.partition("=")
    factors = {}
    for term in terms.split(","):
        case, _, factor = (part.strip() for part in term.partition(":"))
        value = number_of(factor)
        if value is None or case in factors:
            raise CraftmeshError(
                f"combine: {text!r}; expected NAME=CASE:FACTOR,CASE:FACTOR,... with each load case once"
            )
        if case not in cases:
            known = ", ".join(cases) or "none: name them by CASE/ before rows of faces"
            raise CraftmeshError(f"combine: {text!r} has load case {case!r}; expected one of {known}")
        factors[case] = value
    return Combination(name.strip(), factors)


def _check_once(rows: Sequence[FaceRow], case: str) -> None:
    places = [(row.plane, row.axis) for row in rows]
    for row, place in zip(rows, places):
        if places.count(place) > 1:
            of_case = f" in load case {case}" if case else ""
            raise CraftmeshError(
                f"faces: {row.plane}.{'xyz'[row.axis]} has several rows{of_case}; keep one"
            )


def check_supports(name: str, cases: Iterable[str], rows: Sequence[FaceRow]) -> None:
    """Refuse cases of a sum or a history that hold or move different faces: it would keep none's supports.

    name: of the sum, for the error.
    """
    held = {
        case: {f"{row.plane}.{'xyz'[row.axis]}" for row in rows_of(rows, case) if row.kind != STRESS}
        for case in cases
    }
    first, *others = held or [""]
    for case in others:
        if apart := held[first] ^ held[case]:
            raise CraftmeshError(
                f"combine: {name} adds {first} and {case}, of which one alone holds or moves "
                f"{', '.join(sorted(apart))}; fix it in the other, or give it a stress in both"
            )

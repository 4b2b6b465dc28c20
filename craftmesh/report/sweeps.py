"""Sweeps: cases that differ only in an element size, and the quantities that the report compares."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np

from craftmesh.options import Options, option

SIZES = ("l_min", "l0", "l_max", "r0", "r1")
FEWEST = 2  # smallest number of sizes for a comparison
Quantity = Literal[
    "K_I", "J", "kink_angle", "largest_K_I", "reaction", "crack_area", "mean_aspect_ratio", "elements"
]
# Titles of the quantities that may be compared, by name.
QUANTITIES = {
    "K_I": "mean K_I along the fronts",
    "J": "mean J along the fronts",
    "kink_angle": "mean absolute kink angle [degrees]",
    "largest_K_I": "largest K_I along the fronts, without uncertain nodes",
    "reaction": "reaction force of the supports",
    "crack_area": "area of the crack",
    "mean_aspect_ratio": "mean aspect ratio of the elements",
    "elements": "number of elements",
}
# For each quantity with a unit, the key in `UnitsOptions.by_quantity` of that unit.
MEASURED_IN = {"K_I": "K", "largest_K_I": "K", "J": "J", "reaction": "force", "crack_area": "area"}
SOLVED = ("K_I", "J", "kink_angle", "largest_K_I", "reaction")


class Sweep(NamedTuple):
    """Cases that differ only in the size `key`, such as sizing.l_min.

    sizes: the values of the key, coarse first; cases: the name of the case with each size.
    """

    key: str
    sizes: tuple[float, ...]
    cases: tuple[str, ...]


def sweeps(records: Mapping[str, Mapping[str, Any]]) -> list[Sweep]:
    """Return the sweeps among cases, those with most cases first; records: case.json by case name.

    If no length of `sizing` (SIZES) varies alone, but several increase together, the cases are one sweep,
    named by the first of these lengths.
    """
    found = []
    families: dict[str, list[str]] = {}
    for name, record in records.items():
        families.setdefault(_all_but_sizes(record), []).append(name)
    for family in families.values():
        sizes = {name: records[name]["config"]["sizing"] for name in family}
        lengths = {name: tuple(own.get(key) for key in SIZES) for name, own in sizes.items()}
        alone = [sweep for key in SIZES for sweep in _over(key, lengths)]
        found += alone or _together(lengths)
    return sorted(found, key=lambda sweep: (-len(sweep.cases), sweep.key, sweep.cases))


def _all_but_sizes(record: Mapping[str, Any]) -> str:
    sections = {
        name: {key: value for key, value in section.items() if name != "sizing" or key not in SIZES}
        if isinstance(section, dict)
        else section
        for name, section in record["config"].items()
    }
    asked = {key: record[key] for key in ("microstructure", "cracks", "growth")}
    return json.dumps([asked, sections], sort_keys=True)


def _over(key: str, lengths: Mapping[str, tuple]) -> list[Sweep]:
    """Return the sweeps over the length `key` with all other lengths equal; lengths: of SIZES by case.

    A sweep has at least FEWEST sizes; of cases with equal lengths it has the first.
    """
    place = SIZES.index(key)
    groups: dict[tuple, dict[float, str]] = {}
    for name, row in lengths.items():
        if row[place] is not None:
            groups.setdefault((*row[:place], *row[place + 1 :]), {}).setdefault(row[place], name)
    return [_sweep(key, group) for group in groups.values() if len(group) >= FEWEST]


def _together(lengths: Mapping[str, tuple]) -> list[Sweep]:
    """Return a list with the sweep of all cases, if their lengths increase together; else [].

    No length may fall while another increases, and the first length that varies must differ in all cases.
    """
    if len(set(lengths.values())) < FEWEST or any(None in row for row in lengths.values()):
        return []
    rows = np.array(list(lengths.values()))
    order = np.lexsort(rows.T[::-1])
    steps = np.diff(rows[order], axis=0)
    if (steps < 0).any() or not (steps > 0).any(axis=1).all():
        return []
    names = list(lengths)
    place = int((np.ptp(rows, axis=0) > 0).argmax())
    if not (steps[:, place] > 0).all():
        return []
    return [_sweep(SIZES[place], {rows[k, place]: names[k] for k in order.tolist()})]


def _sweep(key: str, by_size: Mapping[float, str]) -> Sweep:
    sizes = sorted(by_size, reverse=True)
    return Sweep(f"sizing.{key}", tuple(map(float, sizes)), tuple(by_size[size] for size in sizes))


@dataclass(frozen=True)
class ReportOptions(Options):
    """Options of the report: the quantity to compare in sweeps, and the convergence tolerance."""

    quantity: Quantity | None = option(
        None,
        "quantity to compare in a sweep over element sizes, solved if needed; none: all available ones",
    )
    tolerance: float = option(
        0.05, "relative difference from the finest size below which a size has converged", above=0
    )

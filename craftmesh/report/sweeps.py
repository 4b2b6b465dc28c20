"""Cases that differ in an element size alone, and what their report compares."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from craftmesh.options import Options, option

SIZES = ("l_min", "l0", "l_max", "r0", "r1")
FEWEST = 2  # sizes that can be compared
# Quantities of a case with one size, by name: what each is in words.
QUANTITIES = {
    "K_I": "mean K_I along the fronts",
    "J": "mean J along the fronts",
    "kink_angle": "mean kink angle, its sign left out [degrees]",
    "largest_K_I": "largest K_I along the fronts, their ends left out",
    "reaction": "force that the supports carry",
    "crack_area": "area of the crack",
    "mean_aspect_ratio": "mean aspect ratio of the elements",
    "elements": "number of elements",
}
# The unit of each, of those that UnitsOptions knows.
MEASURED_IN = {"K_I": "K", "largest_K_I": "K", "J": "J", "reaction": "force", "crack_area": "area"}
SOLVED = ("K_I", "J", "kink_angle", "largest_K_I", "reaction")


class Sweep(NamedTuple):
    """Cases that differ in a size alone: its name (`sizing.l_min`), the sizes, coarse first, the cases."""

    key: str
    sizes: tuple[float, ...]
    cases: tuple[str, ...]


def sweeps(records: Mapping[str, Mapping[str, Any]]) -> list[Sweep]:
    """Return the sweeps among cases (case.json by name), those over more sizes first.

    Where lengths of `sizing` rise together, and none alone, the sweep is named by the first of them.
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
    """Return the sweeps over one length, the others being equal."""
    place = SIZES.index(key)
    groups: dict[tuple, dict[float, str]] = {}
    for name, row in lengths.items():
        if row[place] is not None:
            groups.setdefault((*row[:place], *row[place + 1 :]), {}).setdefault(row[place], name)
    return [_sweep(key, group) for group in groups.values() if len(group) >= FEWEST]


def _together(lengths: Mapping[str, tuple]) -> list[Sweep]:
    """Return the sweep of cases whose lengths all rise together, if they do."""
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
    """What is compared where cases differ in an element size alone, and when it has converged."""

    quantity: str | None = option(
        None,
        "quantity of a sweep over element sizes, solved where it asks for that; none: all that are there",
        choices=tuple(QUANTITIES),
    )
    tolerance: float = option(
        0.05, "a size has converged where it and all finer ones are within this of the finest", above=0
    )

"""The summary of many seeds: outcomes by kind, quantiles, faults, the worst seeds of every check."""

from collections import Counter
from collections.abc import Iterable

import numpy as np

from trials.verdict import GOAL, ROOM

FIGURES = {
    "front_node": ("front node off, l_min", 1),
    "front_middle": ("front edge's middle off, l_min", 1),
    "facet_node": ("crack node off, l_min", 1),
    "facet": ("crack facet's middle off, l_min", 1),
    "area_off_pct": ("crack area off, %", 1),
    "wedge_after": ("least wedge, degrees", -1),
    "dihedral_min": ("least dihedral, degrees", -1),
    "ar_mean": ("mean AR", 1),
    "ar_under_5_pct": ("AR<5, %", -1),
    "poor_pct": ("poor, %", 1),
    "flat": ("flat tets", 1),
    "drift_mean_pct": ("grain volume drift, mean, %", 1),
    "tets": ("tets", 1),
    "cpu_s": ("CPU s", 1),
}
WORST = 5


def markdown(rows: list[dict]) -> str:
    """Return the summary as markdown tables."""
    rows = sorted(rows, key=lambda row: row["seed"])
    parts = [_outcomes(rows), _faults(rows), _figures(rows)]
    refused = [row for row in rows if row["outcome"] == "refusal"]
    if refused:
        parts.append(_refusals(refused))
    return "\n\n".join(parts) + "\n"


def _table(head: tuple, rows: Iterable) -> str:
    lines = ["| " + " | ".join(head) + " |", "|" + " --- |" * len(head)]
    return "\n".join([*lines, *("| " + " | ".join(map(str, row)) + " |" for row in rows)])


def _outcomes(rows: list[dict]) -> str:
    lines = []
    for key in ("volume", "crack", "relief", "place"):
        for kind in sorted({row[key] for row in rows if key in row}):
            chosen = [row for row in rows if row.get(key) == kind]
            lines.append((f"{key}: {kind}", *_counts(chosen)))
    head = ("kind", "seeds", "decks", "refused rightly", "refused wrongly", "crashed", "with a fault")
    return _table(head, [*lines, ("**all**", *_counts(rows))])


def _counts(rows: list[dict]) -> tuple[int, ...]:
    outcome = Counter(row["outcome"] for row in rows)
    wrong = sum("refused" in row["faults"] for row in rows)
    faulty = sum(bool(row["faults"]) for row in rows)
    return len(rows), outcome["deck"], outcome["refusal"] - wrong, wrong, outcome["crash"], faulty


def _faults(rows: list[dict]) -> str:
    lines = []
    for check, room in ROOM.items():
        seeds = [row["seed"] for row in rows if check in row["faults"]]
        if seeds:
            more = f" and {len(seeds) - 12} more" if len(seeds) > 12 else ""
            lines.append((check, room, len(seeds), " ".join(map(str, seeds[:12])) + more))
    return _table(("fault", "room", "seeds", "which"), lines or [("none", "", 0, "")])


def _figures(rows: list[dict]) -> str:
    lines = []
    for key, (name, sign) in FIGURES.items():
        known = [(row[key], row["seed"]) for row in rows if row.get(key) is not None]
        if not known:
            continue
        values = np.array([value for value, _ in known])
        worst = sorted(known, key=lambda pair: -sign * pair[0])[:WORST]
        quantiles = [f"{q:.4g}" for q in np.percentile(sign * values, (50, 95, 100)) * sign]
        lines.append((name, *quantiles, " ".join(str(seed) for _, seed in worst)))
    decks = [row for row in rows if row["outcome"] == "deck"]
    if decks:
        for key, goal in GOAL.items():
            sign = FIGURES[key][1]
            share = 100 * np.mean([sign * row[key] <= sign * goal for row in decks])
            bound = "at most" if sign > 0 else "at least"
            lines.append((f"decks with {FIGURES[key][0]} {bound} {goal:g}", f"{share:.1f} %", "", "", ""))
        with_flat = sum(row["flat"] > 0 for row in decks)
        lines.append(("decks with flat tets", f"{with_flat} of {len(decks)}", "", "", ""))
    return _table(("figure", "median", "95 % worse", "worst", "worst seeds"), lines)


def _refusals(rows: list[dict]) -> str:
    """Return the reasons of the refusals with an example each, those that were wrong one by one."""
    by_reason: dict[tuple, list[dict]] = {}
    for row in rows:
        right = row["may_be_refused"]
        key = (right, row["stage"]) if right else ("**wrong**", row["stage"], row["seed"])
        by_reason.setdefault(key, []).append(row)
    lines = []
    for (reason, stage, *_), alike in sorted(by_reason.items(), key=lambda item: -len(item[1])):
        message = alike[0]["message"].replace("|", "/")[:160]
        lines.append((reason, stage, len(alike), alike[0]["seed"], message))
    return _table(("refused because", "at", "seeds", "such as", "message"), lines)

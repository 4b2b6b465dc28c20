"""What became of each grain: failed attempts and poor tets left, for the log and quality.json."""

from collections.abc import Sequence


def record_of(mesher: str, report: dict, left: Sequence[int], repair: dict | None) -> dict:
    """Return the record of a chunk of grains, from the report of `tetrahedralize` ({} without one).

    `left`: ids of the grains that have no tets yet; `repair`: the report of the repair of the surface,
    if anything was changed. Times are left out, so that the same input gives the same record.
    """
    return {
        "mesher": mesher,
        "repair": repair,
        "tried_again": {grain: _timeless(tried) for grain, tried in report.get("tried_again", {}).items()},
        "failed": {
            grain: one | {"attempts": _timeless(one["attempts"])}
            for grain, one in report.get("failed", {}).items()
        },
        "poor": report.get("poor", {}),
        "left": sorted(left),
    }


def merged(records: Sequence[dict]) -> dict:
    """Return one record of the chunks' records, which are of one surface."""
    records = [record for record in records if record]
    if not records:
        return {}
    return {
        "mesher": records[0]["mesher"],
        "repair": records[0]["repair"],
        "tried_again": _by_grain(records, "tried_again"),
        "failed": _by_grain(records, "failed"),
        "poor": _by_grain(records, "poor"),
        "left": sorted(grain for record in records for grain in record["left"]),
    }


def with_counts(
    record: dict,
    whole_model: dict | None,
    given_way: dict | None,
    smoothed: dict | None,
    poor: dict[str, list[dict]],
) -> dict:
    """Return the record as in quality.json: with numbers of grains, and what was done to the whole model.

    given_way: the report of the surface that gave way to poor tets; smoothed: that of its points that slid
    along it; poor: the rows of grains that changed by that, in place of those in the record.
    """
    counts = {f"grains_{name}": len(record.get(name, ())) for name in ("tried_again", "failed")}
    kept = {grain: rows for grain, rows in (record.get("poor", {}) | poor).items() if rows}
    rest = {"poor": kept, "whole_model": whole_model, "given_way": given_way, "smoothed": smoothed}
    return counts | record | rest


def _timeless(attempts: Sequence[dict]) -> list[dict]:
    return [{key: value for key, value in one.items() if key != "seconds"} for one in attempts]


def _by_grain(records: Sequence[dict], name: str) -> dict:
    together = {grain: one for record in records for grain, one in record[name].items()}
    return {grain: together[grain] for grain in sorted(together, key=int)}

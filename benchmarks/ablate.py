"""The corpus of random cracks, meshed again and held against its known rows: what a change does to them.

`corpus.csv` has a row for each seed: those that commits and comments name, which are the worst there are,
and fresh ones. A mechanism without which they stay as good is not needed.
"""

import argparse
import csv
import json
import multiprocessing
import tempfile
from pathlib import Path

from measure import print_table
from trials.one_seed import TIME_LIMIT, Trial, run_inside
from trials.verdict import GOAL

CORPUS = Path(__file__).resolve().parent / "corpus.csv"
FIGURES = ("flat", "area_off_pct", "ar_under_5_pct", "ar_mean", "tets", "cpu_s")
COLUMNS = ("seed", "outcome", "faults", *FIGURES, "deck")
AR, LEAST = "ar_under_5_pct", GOAL["ar_under_5_pct"]

Row = dict[str, str]


def parser() -> argparse.ArgumentParser:
    flags = argparse.ArgumentParser(description=__doc__)
    flags.add_argument("rows", type=Path, help="the new rows; seeds that it has are left out")
    flags.add_argument("--corpus", type=Path, default=CORPUS, metavar="FILE", help="the known rows")
    flags.add_argument("--only", type=int, nargs="+", metavar="SEED", help="these seeds in place of all")
    flags.add_argument("--renew", action="store_true", help="put the new rows into the corpus")
    return flags


def main() -> None:
    arguments = parser().parse_args()
    known, rows = read_rows(arguments.corpus), read_rows(arguments.rows)
    seeds = arguments.only or list(known)
    for seed in seeds:
        if seed not in rows:
            rows[seed] = short_row(run_forked(seed))
            write_rows(arguments.rows, rows)
            print(*rows[seed].values(), flush=True)
    print_table(
        compared(known, {seed: rows[seed] for seed in seeds}), {"what": "", "before": "", "now": ""}
    )
    if arguments.renew:
        write_rows(arguments.corpus, known | rows)


def run_forked(seed: int) -> dict:
    """Return the row of a seed, made by a fork of this process; a crash or a hang is a row too."""
    with tempfile.TemporaryDirectory() as scratch:
        target = Path(scratch) / "row.json"
        context = multiprocessing.get_context("fork")
        process = context.Process(target=run_inside, args=(seed, target, Trial()))
        process.start()
        process.join(TIME_LIMIT)
        if process.is_alive():
            process.kill()
            process.join()
        row = json.loads(target.read_text()) if target.exists() else {"seed": seed}
    if "outcome" not in row:
        row |= {"outcome": "crash", "faults": {"crash": f"ended with code {process.exitcode}"}}
    return row


def short_row(row: dict) -> Row:
    """Return the columns of a row that the corpus has."""
    figures = {key: f"{row[key]:.6g}" for key in FIGURES if row.get(key) is not None}
    known = {key: str(row.get(key, "")) for key in COLUMNS} | figures
    return known | {"faults": " + ".join(row["faults"])}


def read_rows(path: Path) -> dict[int, Row]:
    """Return a file's rows by seed; none of a file that is not there."""
    if not path.exists():
        return {}
    with path.open(newline="") as stream:
        return {int(row["seed"]): row for row in csv.DictReader(stream)}


def write_rows(path: Path, rows: dict[int, Row]) -> None:
    """Write rows in the order of their seeds."""
    with path.open("w", newline="") as stream:
        writer = csv.DictWriter(stream, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows[seed] for seed in sorted(rows))


def compared(known: dict[int, Row], rows: dict[int, Row]) -> list[dict[str, str | int | float]]:
    """Return the lines of the table: counts and sums of the seeds that both have run, then what differs."""
    seeds = sorted(seed for seed in known.keys() & rows.keys() if known[seed]["outcome"])
    both = [[known[seed] for seed in seeds], [rows[seed] for seed in seeds]]
    lines = [
        {"what": what, "before": count(both[0]), "now": count(both[1])} for what, count in COUNTS.items()
    ]
    for seed, before, now in zip(seeds, *both):
        for key in ("outcome", "faults"):
            if before[key] != now[key]:
                lines.append({"what": f"{seed}: {key}", "before": before[key], "now": now[key]})
    others = sum(before["deck"] != now["deck"] for before, now in zip(*both))
    return [*lines, {"what": "decks that are others", "before": "", "now": others}]


def _sum(key: str):
    return lambda rows: round(sum(float(row[key] or 0) for row in rows), 1)


def _number(is_counted):
    return lambda rows: sum(map(is_counted, rows))


COUNTS = {
    "decks": _number(lambda row: row["outcome"] == "deck"),
    "refused": _number(lambda row: row["outcome"] == "refusal"),
    "with a fault": _number(lambda row: bool(row["faults"])),
    "with flat tets": _number(lambda row: float(row["flat"] or 0) > 0),
    f"AR<5 >= {LEAST} %": _number(lambda row: float(row[AR] or 0) >= LEAST),
    "flat tets": _sum("flat"),
    "tets": _sum("tets"),
    "CPU s": _sum("cpu_s"),
}

if __name__ == "__main__":
    main()

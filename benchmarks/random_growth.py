"""Random cracks that grow in a closed loop: each increment's deck is checked as in `random_cracks.py`.

A refusal to mesh or to grow is a fault, unless the crack has left the body or runs along a face.
"""

import argparse
import json
import sys
import tempfile
from collections import Counter
from pathlib import Path

from trials.one_seed import JUDGE, cpu_seconds, script_apart

SIDES = (22, 34)  # voxels
MOST_TETS = 50_000  # of the first increment
INCREMENTS = 6
COLUMNS = ("campaigns", "decks", "ends", "decks with flat tets", "repairs", "trusted, %")  # of `by_kind`
TIME_LIMIT = 900.0  # s; a seed takes 30 to 120 of CPU


def parser() -> argparse.ArgumentParser:
    flags = argparse.ArgumentParser(description=__doc__)
    flags.add_argument("first", type=int, help="first seed")
    flags.add_argument("last", type=int, help="last seed")
    flags.add_argument("--increments", type=int, default=INCREMENTS, metavar="N", help="decks at most")
    flags.add_argument("--judge", action="store_true", help="ask the judge in ../shared/judge as well")
    flags.add_argument(
        "--correct", action=argparse.BooleanOptionalAction, default=True, help="grow.correct (default on)"
    )
    flags.add_argument("--reuse", action="store_true", help="renew the mesh of the increment before")
    flags.add_argument("--json", type=Path, metavar="FILE", help="append a line for each seed as it ends")
    flags.add_argument("--keep", type=Path, metavar="FOLDER", help="keep the files of the one seed here")
    flags.add_argument("--time-limit", type=float, default=TIME_LIMIT, metavar="S", help="of one seed")
    flags.add_argument("--kinds", action="store_true", help="a shape, material and roughness by each seed")
    flags.add_argument("--inside", type=Path, help=argparse.SUPPRESS)
    return flags


def main() -> None:
    arguments = parser().parse_args()
    if arguments.inside:
        run_inside(arguments)
        return
    if arguments.keep and arguments.first != arguments.last:
        sys.exit("--keep takes one seed; give it as first and last")
    flags = ["--increments", str(arguments.increments)]
    flags += [] if arguments.correct else ["--no-correct"]
    flags += ["--reuse"] if arguments.reuse else []
    flags += ["--kinds"] if arguments.kinds else []
    flags += ["--judge"] if arguments.judge and JUDGE.exists() else []
    flags += ["--keep", str(arguments.keep.resolve())] if arguments.keep else []
    rows = []
    for seed in range(arguments.first, arguments.last + 1):
        row = script_apart(Path(__file__).resolve(), seed, flags, arguments.time_limit)
        rows.append(row)
        print(told(row), flush=True)
        if arguments.json is not None:
            with arguments.json.open("a") as stream:
                stream.write(json.dumps(row) + "\n")
    print(f"\n{summary(rows)}")
    if arguments.kinds:
        print(f"\n{by_kind(rows)}")


def run_inside(arguments: argparse.Namespace) -> None:
    """Draw one seed's case and let it grow in this process; write its row."""
    from trials import drawing
    from trials.closed_loop import closed_loop
    from trials.kinds import draw_kind

    drawing.MOST_TETS = MOST_TETS
    case = draw_kind(arguments.first) if arguments.kinds else drawing.draw_one(arguments.first, SIDES)
    row = {"seed": arguments.first, "words": case.words, **case.kinds, "l_min": case.sizes.l_min}
    arguments.inside.write_text(json.dumps(row))
    with tempfile.TemporaryDirectory() as scratch:
        folder = arguments.keep or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        row |= closed_loop(
            case, folder, arguments.increments, arguments.judge, arguments.correct, arguments.reuse
        )
    row["outcome"] = "grown"
    row["cpu_s"] = cpu_seconds()
    arguments.inside.write_text(json.dumps(row))


def told(row: dict) -> str:
    """Return a seed's line."""
    decks = len(row.get("rows", []))
    found = "; ".join(f"{name.upper()} {text}" for name, text in row["faults"].items())
    said = found or row.get("ended") or "sound"
    return f"{row['seed']:6d} {row['seconds']:5.0f} s {decks} decks  {row.get('words', '')}: {said}"


def summary(rows: list[dict]) -> str:
    """Return counts of seeds and decks, of faults among them, and the worst figures."""
    decks = [deck for row in rows for deck in row.get("rows", [])]
    lines = [
        f"{len(rows)} seeds, {len(decks)} decks; without a fault: {sum(not row['faults'] for row in rows)} "
        f"seeds, {sum(not deck['faults'] for deck in decks)} decks",
        f"{sum(deck.get('renewed') is not None and deck['renewed'] < 1 for deck in decks)} decks renewed",
        f"flat tets in {sum(deck['flat'] > 0 for deck in decks)} decks",
    ]
    for key, worst in (("front_node", max), ("facet", max), ("ar_under_5_pct", min), ("poor_pct", max)):
        known = [deck[key] for deck in decks if deck.get(key) is not None]
        if known:
            lines.append(f"worst {key}: {worst(known):.4g}")
    return "\n".join(lines)


def by_kind(rows: list[dict]) -> str:
    """Return a markdown table: campaigns, ends by reason, flat tets and trusted K for each kind."""
    kinds = sorted({(key, row[key]) for row in rows for key in ("crack", "volume", "relief")})
    lines = [" | ".join(("kind", *COLUMNS)), " | ".join(["---"] * (len(COLUMNS) + 1))]
    for key, kind in [*kinds, ("", "all")]:
        own = [row for row in rows if not key or row[key] == kind]
        decks = [deck for row in own for deck in row.get("rows", [])]
        ends = Counter(row.get("end") or "fault: crash" for row in own)
        nodes = sum(deck.get("nodes", 0) for deck in decks)
        told = "; ".join(f"{end} {count}" for end, count in sorted(ends.items()))
        flat = sum(deck["flat"] > 0 for deck in decks)
        trusted = 100 * sum(deck.get("trusted", 0) for deck in decks) / max(nodes, 1)
        repairs = sum(sum((deck.get("repairs") or {}).values()) for deck in decks)
        cells = (kind, len(own), len(decks), told, flat, repairs, f"{trusted:.1f}")
        lines.append(" | ".join(map(str, cells)))
    return "\n".join(f"| {line} |" for line in lines)


if __name__ == "__main__":
    main()

"""Random cracks in random volumes: each seed's model is drawn, meshed and checked; faults are counted.

A refusal is right where the crack lies outside the material, or in or almost in a face of the box. A crash
or a hang of one seed counts as its fault, and the next goes on.
"""

import argparse
import json
import sys
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from trials.more_cracks import KINDS
from trials.one_seed import JUDGE, TIME_LIMIT, Trial, run_apart, run_inside
from trials.summary import markdown


def parser() -> argparse.ArgumentParser:
    flags = argparse.ArgumentParser(description=__doc__)
    flags.add_argument("first", type=int, help="first seed")
    flags.add_argument("last", type=int, help="last seed")
    flags.add_argument("--workers", type=int, default=1, metavar="N", help="seeds at once (default 1)")
    flags.add_argument("--json", type=Path, metavar="FILE", help="append a line for each seed as it ends")
    flags.add_argument("--resume", action="store_true", help="leave out the seeds that --json has")
    flags.add_argument("--markdown", type=Path, metavar="FILE", help="write the summary's tables to FILE")
    flags.add_argument("--judge", action="store_true", help="ask the judge in ../shared/judge as well")
    flags.add_argument("--only", type=int, nargs="+", metavar="SEED", help="only these seeds of the range")
    flags.add_argument("--kind", choices=KINDS, help="draw this kind of crack alone")
    flags.add_argument(
        "--keep", type=Path, metavar="FOLDER", help="keep the one seed's inputs and every stage's file"
    )
    flags.add_argument("--time-limit", type=float, default=TIME_LIMIT, metavar="S", help="of one seed")
    flags.add_argument("--inside", type=Path, help=argparse.SUPPRESS)
    return flags


def main() -> None:
    arguments = parser().parse_args()
    seeds = arguments.only or list(range(arguments.first, arguments.last + 1))
    judged = arguments.judge and JUDGE.exists()
    trial = Trial(judged, arguments.keep, arguments.kind)
    if arguments.inside:
        run_inside(seeds[0], arguments.inside, trial)
        return
    if arguments.judge and not judged:
        print(f"judge: skipped, {JUDGE.name} is not in ../shared/judge")
    if arguments.keep and len(seeds) != 1:
        sys.exit("--keep takes one seed; give --only SEED")
    rows = known_rows(arguments.json) if arguments.resume else []
    done = {row["seed"] for row in rows}
    with ThreadPoolExecutor(arguments.workers) as pool:
        started = [
            pool.submit(run_apart, seed, trial, arguments.time_limit) for seed in seeds if seed not in done
        ]
        for future in as_completed(started):
            row = future.result()
            rows.append(row)
            tell(row, arguments.json)
    rows = [row for row in rows if row["seed"] in set(seeds)]
    summary = markdown(rows)
    print(f"\n{summary}")
    if arguments.markdown:
        arguments.markdown.write_text(heading(rows) + summary)


def heading(rows: list[dict]) -> str:
    """Return what stands above the tables of the summary in a page of the documentation."""
    commits = ", ".join(sorted({row.get("commit") or "unknown" for row in rows}))
    seeds = sorted(row["seed"] for row in rows)
    lines = [
        "# Random cracks\n",
        f"Results of `benchmarks/random_cracks.py` for {len(rows)} seeds, {seeds[0]} to {seeds[-1]},",
        f"at the commits {commits}. This command renews the page:\n",
        "```",
        f"python benchmarks/random_cracks.py {seeds[0]} {seeds[-1]} --judge --json rows.jsonl --resume \\",
        "  --markdown docs/random_cracks.md",
        "```\n",
        "Draw of cases and list of faults: [benchmarks](../benchmarks/README.md#random-cracks).",
        "If a crack meets a face of the box at θ degrees, no mesh can avoid tetrahedra along its",
        "mouth with an aspect ratio of at least 1 / sin θ, which exceeds 5 if θ is below 11.5 degrees.\n\n",
    ]
    return "\n".join(lines)


def known_rows(path: Path | None) -> list[dict]:
    """Return the rows of a file, of each seed the last."""
    if path is None or not path.exists():
        return []
    rows = [json.loads(line) for line in path.read_text().splitlines()]
    return list({row["seed"]: row for row in rows}.values())


def tell(row: dict, path: Path | None) -> None:
    """Print a seed's line, and append its row to the file."""
    found = "; ".join(f"{check.upper()} {text}" for check, text in row["faults"].items())
    right = row.get("may_be_refused")
    said = f"{row.get('message', '')[:120]} ({right})" if row["outcome"] == "refusal" and right else ""
    what = f"{row.get('words', '')}: {found or said or 'sound'}"
    print(f"{row['seed']:6d} {row['seconds']:5.0f} s {row['outcome']:8s} {what}", flush=True)
    if path is not None:
        with path.open("a") as stream:
            stream.write(json.dumps(row) + "\n")


if __name__ == "__main__":
    main()

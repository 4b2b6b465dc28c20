"""Speed over time: stages beside TetGen's own time in the same process, kept in docs/speed.csv.

    python benchmarks/speed.py           # measures all cases, appends a row for each stage: `make bench`
    python benchmarks/speed.py --check   # `small` against the last row of this machine: `make speed`

Other work on the machine changes the ratio to TetGen's time less than the seconds.
"""

import argparse
import csv
import datetime
import os
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from cases import G26, G100, ROOT, Case, generated
from measure import cpu_seconds, in_child, peak_megabytes

RECORD = ROOT / "docs" / "speed.csv"
FIELDS = ("date", "commit", "machine", "case", "stage", "cpu_s", "tetgen_s", "ratio", "peak_mb")
CASES = {"small": Case(generated, (24, 6)), "g26": G26, "g100": G100}
SWITCHES = "pYq1.1AQ"  # a finer mesh than craftmesh asks TetGen for, which takes longer
# calls in a try, of which the quickest counts: ten tries beside ten other processes scattered by 3 to 4 %
TETGEN_CALLS, GRADATE_CALLS = 5, 2
SLOWER = 1.15  # ratio over the last one that is accepted
TRIES = 3


@contextmanager
def nothing_printed() -> Iterator[None]:
    """Keep what C code prints from the output."""
    sys.stdout.flush()
    output, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        os.dup2(output, 1)
        os.close(output)
        os.close(nowhere)


def seconds_of(function: Callable, *arguments: Any) -> float:
    """Return the CPU seconds of a call, workers included."""
    before = cpu_seconds()
    function(*arguments)
    return cpu_seconds() - before


def tries(case: Case) -> Iterator[dict[str, dict]]:
    """Yield the figures of each stage, time after time; before, the kernels are compiled."""
    from craftmesh.gradation.gradate import gradate
    from craftmesh.tetrahedra.grain_surface import grain_surfaces
    from craftmesh.tetrahedra.meshers import TetGenMesher
    from craftmesh.tetrahedra.volume import mesh_volume

    start = case.start()
    gradated, _ = gradate(start.surface, start.sizing)
    mesh_volume(gradated, start.sizing, None, start.islands)
    grains, mesher, nothing = grain_surfaces(gradated), TetGenMesher(), np.zeros((0, 3))

    def tetgen() -> None:
        for grain in grains:
            with nothing_printed():
                mesher.mesh(
                    grain.points, grain.facets, np.ones(len(grain.facets)), nothing, nothing, SWITCHES
                )

    while True:
        alone = min(seconds_of(tetgen) for _ in range(TETGEN_CALLS))
        taken = {
            "gradate": min(seconds_of(gradate, start.surface, start.sizing) for _ in range(GRADATE_CALLS)),
            "tetrahedralize": seconds_of(mesh_volume, gradated, start.sizing, None, start.islands),
        }
        yield {
            stage: {
                "cpu_s": round(seconds, 2),
                "tetgen_s": round(alone, 2),
                "ratio": round(seconds / alone, 3),
                "peak_mb": round(peak_megabytes()),
            }
            for stage, seconds in taken.items()
        }


def median_try(case: Case) -> dict[str, dict]:
    """Return the figures of each stage of the try, of TRIES, whose ratio is the middle one."""
    found = [one for _, one in zip(range(TRIES), tries(case))]
    return {
        stage: sorted((one[stage] for one in found), key=lambda row: row["ratio"])[TRIES // 2]
        for stage in found[0]
    }


def here() -> dict[str, str]:
    """Return the day, the commit and the machine."""
    git = ["git", "-C", str(ROOT), "describe", "--always", "--dirty"]
    lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    models = [line.partition(": ")[2] for line in lines if line.startswith("model name")]
    return {
        "date": datetime.date.today().isoformat(),
        "commit": subprocess.run(git, capture_output=True, text=True, check=True).stdout.strip(),
        "machine": f"{models[0] if models else 'unknown'}, {os.cpu_count()} cores",
    }


def accepted(rows: Iterable[dict], machine: str, case: str) -> dict[str, float]:
    """Return the last ratio of each stage of a case on a machine."""
    return {
        row["stage"]: float(row["ratio"])
        for row in rows
        if (row["machine"], row["case"]) == (machine, case)
    }


def slower(ratios: Iterable[dict[str, float]], limits: dict[str, float]) -> list[str]:
    """Return the stages that are over their limits in two of the tries; no third is asked for in vain."""
    times = dict.fromkeys(limits, 0)
    for done, ratio in enumerate(ratios, 1):
        for stage, limit in limits.items():
            times[stage] += ratio[stage] > limit
        if done >= 2 and all(count >= 2 or count == 0 for count in times.values()):
            break
    return [stage for stage, count in times.items() if count >= 2]


def check(path: Path) -> str | None:
    """Return which stages of `small` are too slow, if any are."""
    with open(path, newline="", encoding="utf-8") as stream:
        last = accepted(csv.DictReader(stream), here()["machine"], "small")
    if not last:
        print(f"speed: {path.name} has no figure of this machine ({here()['machine']})")
        return None

    def told() -> Iterator[dict[str, float]]:
        for _, one in zip(range(TRIES), tries(CASES["small"])):
            ratios = {stage: figures["ratio"] for stage, figures in one.items()}
            print("speed:", *(f"{stage} {ratio} ({last[stage]})" for stage, ratio in ratios.items()))
            yield ratios

    stages = slower(told(), {stage: SLOWER * ratio for stage, ratio in last.items()})
    return f"{' and '.join(stages)}: twice over {SLOWER} times the ratio of {path.name}" if stages else None


def record(path: Path, names: Iterable[str]) -> None:
    """Append the figures of the cases to the record, and print them."""
    for name in names:
        if CASES[name].missing:
            print(f"{name}: skipped, {CASES[name].missing}")
            continue
        for stage, figures in in_child(median_try, CASES[name]).items():
            row = here() | {"case": name, "stage": stage} | figures
            with open(path, "a", newline="", encoding="utf-8") as stream:
                writer = csv.DictWriter(stream, FIELDS, lineterminator="\n")
                if not stream.tell():
                    writer.writeheader()
                writer.writerow(row)
            print(*row.values())


def main() -> str | None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--check", action="store_true", help="fail where `small` is slower than it was")
    parser.add_argument("--case", action="append", choices=CASES, help="only this case")
    parser.add_argument("--file", type=Path, default=RECORD, help="the record (default docs/speed.csv)")
    arguments = parser.parse_args()
    if arguments.check:
        return check(arguments.file)
    return record(arguments.file, arguments.case or CASES)


if __name__ == "__main__":
    sys.exit(main())

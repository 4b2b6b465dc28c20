"""From voxels to a deck at growing size: cubes of N grains of 20^3 voxels with a penny, a process a stage.

    python benchmarks/scale.py 125 1000 --folder results/scale   # keeps stages that are done in the folder

CPU seconds are those of a stage's process and its workers, peak MB those of the largest of these. A slope
is the exponent of the number of grains from one size to the next; memory is continued as a straight line.
"""

import argparse
import json
import math
import os
import subprocess
import sys
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path

VOXELS = 20  # along the edge of a grain, were it a cube
SIZES = "--l-min 0.5 --l0 1 --l-max 3 --r0 8 --r1 16 --exponent 1"
STAGES = {
    "generate": "generate --shape {edge} {edge} {edge} --grains {grains} --seed 1 -o generated.npz",
    "import": "import generated.npz --labels labels.npz --image volume.vti --islands islands.json "
    "--allow-single-grain",
    "remesh": "remesh labels.npz -o remeshed.vtp",
    "crack": "crack labels.npz --centre {half} {half} {half} --normal 0.1 0.2 1 --radius {radius} "
    "-o crack.vtp",
    "size": f"size remeshed.vtp --crack crack.vtp --labels labels.npz {SIZES} -o sizing.npz",
    "stitch": "stitch remeshed.vtp --crack crack.vtp --sizing sizing.npz -o surface.vtp",
    "gradate": "gradate surface.vtp --crack crack.vtp --sizing sizing.npz -o gradated.vtp",
    "tetrahedralize": "tetrahedralize gradated.vtp --islands islands.json --sizing sizing.npz "
    "--report tets.json -o volume.vtu",
    "inp": "inp volume.vtu --element C3D4 --microstructure labels.npz -o model.inp",
}
MACHINE_GB = 24


@dataclass(frozen=True)
class Cost:
    """What a stage took."""

    cpu_s: float
    peak_mb: float


def run_stage(folder: Path, stage: str, line: str) -> Cost:
    """Return a stage's cost in `folder`, run unless its cost lies there."""
    kept = folder / f"{stage}.cost.json"
    if not kept.exists():
        print(f"{folder.name} grains: {stage}", file=sys.stderr, flush=True)
        with open(folder / f"{stage}.log", "w") as log:
            command = [sys.executable, "-m", "craftmesh.cli", *line.split()]
            process = subprocess.Popen(command, cwd=folder, stdout=log, stderr=log)
            _, status, usage = os.wait4(process.pid, 0)
        if status:
            sys.exit(f"{stage} fails, see {log.name}")
        cost = Cost(usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024)
        partial = kept.with_suffix(".tmp")
        partial.write_text(json.dumps(asdict(cost)))
        partial.rename(kept)
    return Cost(**json.loads(kept.read_text()))


def measured(grains: int, folder: Path) -> dict[str, Cost]:
    """Return the cost of each stage for a cube of so many grains."""
    folder.mkdir(parents=True, exist_ok=True)
    edge = round(VOXELS * grains ** (1 / 3))
    places = {"edge": edge, "grains": grains, "half": edge / 2, "radius": edge / 4}
    return {stage: run_stage(folder, stage, line.format(**places)) for stage, line in STAGES.items()}


def tets_of(folder: Path) -> int:
    """Return the number of tetrahedra of a size that is done."""
    return json.loads((folder / "tets.json").read_text())["tets"]


def slope(sizes: tuple[float, float], values: tuple[float, float]) -> float:
    """Return p of values ~ size ** p."""
    return math.log(values[1] / values[0]) / math.log(sizes[1] / sizes[0])


def grains_that_fit(sizes: tuple[int, int], peaks: tuple[float, float], megabytes: float) -> float:
    """Return the number of grains at which memory, a straight line of it, reaches `megabytes`."""
    rate = (peaks[1] - peaks[0]) / (sizes[1] - sizes[0])
    return sizes[1] + (megabytes - peaks[1]) / rate if rate > 0 else math.inf


def table(found: dict[int, dict[str, Cost]], tets: dict[int, int]) -> list[str]:
    """Return the lines of a table: a stage a line, the sizes side by side, then the slopes."""
    steps = list(pairwise(found))
    heads = [f"{grains:,} grains, {tets[grains]:,} tets" for grains in found]
    heads += [f"slope to {after:,}" for _, after in steps] + (
        [f"grains in {MACHINE_GB} GB"] if steps else []
    )
    lines = ["| CPU s / peak MB | " + " | ".join(heads) + " |", "|---" * (len(heads) + 1) + "|"]
    for stage in STAGES:
        cells = [f"{costs[stage].cpu_s:.1f} / {costs[stage].peak_mb:,.0f}" for costs in found.values()]
        cells += [f"{slope(step, tuple(found[n][stage].cpu_s for n in step)):.2f}" for step in steps]
        if steps:
            peaks = tuple(found[n][stage].peak_mb for n in steps[-1])
            cells.append(f"{grains_that_fit(steps[-1], peaks, 1024 * MACHINE_GB):,.0f}")
        lines.append(f"| {stage} | " + " | ".join(cells) + " |")
    sums = {n: sum(cost.cpu_s for cost in costs.values()) for n, costs in found.items()}
    cells = [f"{sums[n]:.1f}" for n in found]
    cells += [f"{slope(step, tuple(sums[n] for n in step)):.2f}" for step in steps] + [""] * bool(steps)
    return [*lines, "| sum | " + " | ".join(cells) + " |"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("grains", nargs="*", type=int, default=[125, 1000], help="sizes (default 125 1000)")
    parser.add_argument("--folder", type=Path, default=Path("results/scale"), help="of the stages' files")
    arguments = parser.parse_args()
    folder = arguments.folder.resolve()
    sizes = sorted(arguments.grains)
    subprocess.run(
        [sys.executable, "-m", "craftmesh.cli", "compile"], check=True, stdout=subprocess.DEVNULL
    )
    found = {grains: measured(grains, folder / str(grains)) for grains in sizes}
    print(*table(found, {grains: tets_of(folder / str(grains)) for grains in sizes}), sep="\n")


if __name__ == "__main__":
    main()

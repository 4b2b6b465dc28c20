"""The path of a crack that grows in a closed loop, against one with half the edges and half the step.

Each path is a campaign of its own: an inclined penny in a pulled cube, one material with grain boundaries.
"""

import argparse
import csv
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from measure import print_table, write_json

EDGE, RADIUS, GROWN = 40, 6.0, 5
CENTRE = np.array([20.2, 19.8, 20.1])
DEGREES = 30.0
LENGTH, STEP = 0.75, 1.5  # an eighth and a quarter of the radius
CONFIG = """
cases: cases.tsv
chunks: 2
generate: {{shape: [{edge}, {edge}, {edge}], grains: 8}}
sizing: {{l0: {l0}, l_min: {length}, l_max: 8.0, r0: 3.0, r1: 12.0}}
cracks: {{penny: {{centre: {centre}, normal: {normal}, radius: {radius}}}}}
grow: {{extension: {step}, smoothing: {smoothing}, correct: {correct}}}
inp: {{material: ["isotropic:70000,0.3"], load: stress, magnitude: 1.0}}
"""
CASES = "case\tmicrostructure\tcrack\tincrements\tgrowth\npath\tsynthetic\tpenny\t{count}\tgrow\n"
AZIMUTHS = np.radians(np.arange(0, 360, 5))
COLUMNS = {
    "grown": "grown by",
    "off": "off the fine path, l_min: mean/max",
    "turned": "direction off, degrees: mean/max",
    "way": "of the way from the first front",
    "mode_ii": "largest |K_II| / K_I",
    "fine_mode_ii": "the fine path's",
    "kink": "kink angle, degrees: least/largest",
}


def campaign(folder: Path, halved: int, smoothing: str, correct: bool) -> Path:
    """Let the penny grow GROWN steps, each cut in `halved`, and return the folder of its increments.

    The last crack is not grown from, but made as if it were: the step before it is then corrected too.
    """
    normal = [float(np.sin(np.radians(DEGREES))), 0.0, float(np.cos(np.radians(DEGREES)))]
    length = LENGTH / halved
    text = CONFIG.format(
        edge=EDGE,
        l0=max(1.0, 1.25 * length),
        length=length,
        centre=CENTRE.tolist(),
        normal=normal,
        radius=RADIUS,
        step=STEP / halved,
        smoothing=smoothing,
        correct=str(correct).lower(),
    )
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "config.yaml").write_text(text)
    (folder / "cases.tsv").write_text(CASES.format(count=GROWN * halved + 2))
    snakefile = Path(__file__).resolve().parents[1] / "Snakefile"
    flags = ["-s", str(snakefile), "--cores", "2", "--configfile", "config.yaml", "--quiet", "all"]
    wanted = f"results/path/{GROWN * halved:03d}/base.vtp"
    subprocess.run([str(Path(sys.executable).parent / "snakemake"), wanted, *flags], cwd=folder, check=True)
    return folder / "results" / "path"


def meridians(case: Path, increment: int) -> np.ndarray:
    """Return where the front that an increment grows from meets the half planes AZIMUTHS (k, 2).

    Distances from the penny's axis, round which these are, and heights along it.
    """
    from craftmesh.io.vtk import read_crack

    tilt = np.radians(DEGREES)
    axes = np.array([[np.cos(tilt), 0, -np.sin(tilt)], [0, 1, 0], [np.sin(tilt), 0, np.cos(tilt)]])
    crack = read_crack(case / f"{increment:03d}" / "base.vtp")
    places = (crack.points[crack.fronts[0][:-1]] - CENTRE) @ axes.T
    turn = np.arctan2(places[:, 1], places[:, 0])
    values = np.column_stack([np.hypot(places[:, 0], places[:, 1]), places[:, 2]])
    return np.stack([np.interp(AZIMUTHS, turn, column, period=2 * np.pi) for column in values.T], axis=1)


def columns(case: Path, increment: int) -> dict[str, np.ndarray]:
    with open(case / f"{increment:03d}" / "sif.csv", newline="", encoding="ascii") as stream:
        rows = list(csv.DictReader(stream))
    return {key: np.array([float(row[key]) for row in rows]) for key in ("K_I", "K_II", "kink_angle")}


def distance_to_path(places: np.ndarray, path: np.ndarray) -> np.ndarray:
    """Return how far places (k, 2) are from paths (n, k, 2), each from its own."""
    start, step = path[:-1], np.diff(path, axis=0)
    share = ((places - start) * step).sum(axis=-1) / np.maximum((step**2).sum(axis=-1), 1e-300)
    feet = start + np.clip(share, 0, 1)[..., None] * step
    return np.linalg.norm(places - feet, axis=-1).min(axis=0)


def compared(coarse: Path, fine: Path) -> list[dict]:
    """Return a row for each increment of the coarse path."""
    ours = np.stack([meridians(coarse, k) for k in range(GROWN + 1)])
    # one step more, for a point at the path's end may be ahead of it
    theirs = np.stack([meridians(fine, k) for k in range(2 * GROWN + 1)])
    last = theirs[-1] + (theirs[-1] - theirs[-2])
    rows = []
    for k in range(GROWN + 1):
        near, far = columns(coarse, k), columns(fine, 2 * k)
        row = {
            "grown": k * STEP,
            "mode_ii": float(np.abs(near["K_II"] / near["K_I"]).max()),
            "fine_mode_ii": float(np.abs(far["K_II"] / far["K_I"]).max()),
            "kink": [float(near["kink_angle"].min()), float(near["kink_angle"].max())],
        }
        if k:
            off = distance_to_path(ours[k], np.concatenate([theirs, last[None]])) / LENGTH
            row["off"] = [float(off.mean()), float(off.max())]
            turn = direction(ours[k] - ours[k - 1]) - direction(theirs[2 * k] - theirs[2 * k - 2])
            row["turned"] = mean_and_most(turn)
            row["way"] = mean_and_most(direction(ours[k] - ours[0]) - direction(theirs[2 * k] - theirs[0]))
        rows.append(row)
    return rows


def mean_and_most(angles: np.ndarray) -> list[float]:
    """Return the mean and the largest size of angles (k,)."""
    return [float(np.abs(angles).mean()), float(np.abs(angles).max())]


def direction(steps: np.ndarray) -> np.ndarray:
    """Return the angles (..., k) of steps (..., k, 2) to the first crack's plane, degrees."""
    return np.degrees(np.arctan2(steps[..., 1], steps[..., 0]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures to this file")
    parser.add_argument("--folder", type=Path, help="keep the campaigns here, and go on where they stopped")
    parser.add_argument("--smoothing", default="fit", help="of the moves along the front (default fit)")
    parser.add_argument(
        "--correct", action=argparse.BooleanOptionalAction, default=True, help="grow.correct (default on)"
    )
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.folder or Path(temporary)
        coarse, fine = (
            campaign(folder / str(cut), cut, arguments.smoothing, arguments.correct) for cut in (1, 2)
        )
        rows = compared(coarse, fine)
    print_table(rows, COLUMNS)
    write_json(arguments.json, {"growth": rows})


if __name__ == "__main__":
    main()

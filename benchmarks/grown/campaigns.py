"""Campaigns of one case whose crack grows, and what they say of it."""

import csv
import json
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

SHEET = "case\tmicrostructure\tcrack\tincrements\tgrowth\npath\t{volume}\tcrack\t{count}\t{growth}\n"
WORDS = ("flags", "stays", "face")  # columns that are no numbers
SNAKEFILE = Path(__file__).resolve().parents[2] / "Snakefile"


class Check(NamedTuple):
    """What was found of a case, what is known of it, and how far off that may be; all in one unit."""

    what: str
    found: float
    known: float
    within: float

    @property
    def holds(self) -> bool:
        return bool(abs(self.found - self.known) <= self.within)


def grown(
    folder: Path,
    config: str,
    increments: int,
    target: str = "",
    growth: str = "grow",
    volume: str = "synthetic",
) -> Path:
    """Run a campaign of one case on one core and return the folder of its increments.

    config: YAML without `cases` and `chunks`, with a crack named `crack`. target: a file under results/path
    in place of the report. volume: the microstructure, a file in the folder.
    """
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "config.yaml").write_text(f"cases: cases.tsv\nchunks: 2\n{config}")
    (folder / "cases.tsv").write_text(SHEET.format(volume=volume, count=increments, growth=growth))
    flags = ["-s", str(SNAKEFILE), "--cores", "1", "--configfile", "config.yaml", "--quiet", "all"]
    snakemake = Path(sys.executable).parent / "snakemake"
    wanted = f"results/{target and 'path/'}{target or 'report.html'}"
    subprocess.run([str(snakemake), wanted, *flags], cwd=folder, check=True)
    return folder / "results" / "path"


def columns(case: Path, increment: int, name: str = "sif.csv") -> dict[str, np.ndarray]:
    """Return the columns of numbers of an increment's sif.csv or front.csv."""
    with open(case / f"{increment:03d}" / name, newline="", encoding="ascii") as stream:
        rows = list(csv.DictReader(stream))
    return {key: np.array([float(row[key]) for row in rows]) for key in rows[0] if key not in WORDS}


def growth(case: Path, increment: int) -> dict[str, float]:
    """Return how an increment's crack goes on, and the cycles to it: `growth` of fracture.json."""
    report = case / f"{increment:03d}" / "fracture.json"
    return json.loads(report.read_text(encoding="utf-8"))["growth"]


def ended(case: Path, increment: int) -> str:
    """Return why the growth ends after an increment, "" where it goes on."""
    return json.loads((case / f"{increment:03d}" / "growth.json").read_text(encoding="utf-8"))["ended"]


def front(case: Path, increment: int, name: str = "base") -> np.ndarray:
    """Return the points (k, 3) of the first front of an increment's crack: base, crack or grown."""
    from craftmesh.io.vtk import read_crack

    crack = read_crack(case / f"{increment:03d}" / f"{name}.vtp")
    return crack.points[crack.fronts[0]]


def places(columns: dict[str, np.ndarray]) -> np.ndarray:
    """Return the points (n, 3) of a front.csv's columns."""
    return np.stack([columns[axis] for axis in "xyz"], axis=1)


def off_front(line: np.ndarray, points: np.ndarray) -> float:
    """Return how far points (n, 3) are from a front (k, 3) at most."""
    from craftmesh.cracks.polyline import feet, polyline

    return float(feet(polyline(line), points)[1].max())

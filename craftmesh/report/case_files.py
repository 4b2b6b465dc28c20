"""A case as its folder in the results has it: what it was asked for, and its increments."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io.front_csv import front_table, read_front, read_words
from craftmesh.io.solution import read_solution
from craftmesh.io.stage_npz import read_sizing
from craftmesh.io.vtk import read_crack
from craftmesh.report.costs import Cost, stage_costs
from craftmesh.report.sweeps import SIZES
from craftmesh.types import Crack

RECORD = "case.json"
PICTURES = ("grains", "sizes", "crack", "deformed", "stress")


@dataclass(frozen=True)
class Increment:
    """An increment's measures, and what else there is of it: None or empty where it was not made.

    quality: quality.json; lengths: those of Eq. 3 by name; front: columns of sif.csv; growth: growth.json;
    reaction: half of all reactions' sizes along the axis where that is largest; pictures: .webp by name;
    scene: scene.json; digests: SHA-256 of files by name.
    """

    name: str
    quality: Mapping[str, Any]
    lengths: Mapping[str, float]
    front: Mapping[str, np.ndarray] | None
    growth: Mapping[str, Any] | None
    crack: Crack | None
    reaction: float | None
    pictures: Mapping[str, bytes]
    scene: Mapping[str, Any] | None
    digests: Mapping[str, str]


@dataclass(frozen=True)
class Case:
    """A case with its increments: record: case.json; imported: import.json; costs: by stage."""

    name: str
    record: Mapping[str, Any]
    imported: Mapping[str, Any]
    digests: Mapping[str, str]
    increments: list[Increment]
    costs: list[Cost]


def read_cases(results: Path) -> list[Case]:
    """Return the cases of all campaigns in a folder of results, by name."""
    return [read_case(path.parent) for path in sorted(results.glob(f"*/{RECORD}"))]


def read_case(folder: Path) -> Case:
    """Return the case in a folder, with the increments that its record asks for and that are measured.

    Increments past one after which the crack stopped are those of an earlier run, and left out. Raises
    CraftmeshError for files that cannot be read.
    """
    record = _json(folder / RECORD)
    increments: list[Increment] = []
    for number in range(record["increments"]):
        place = folder / f"{number:03d}"
        if not (place / "quality.json").is_file():
            break
        increments.append(_increment(place))
        growth = increments[-1].growth
        if record["growth"] != "prescribed" and growth is not None and growth["ended"]:
            break
    report = folder / "import.json"
    return Case(
        name=folder.name,
        record=record,
        imported=_json(report) if report.is_file() else {},
        digests=_digests(folder, ("labels.npz",)),
        increments=increments,
        costs=stage_costs(folder.parent / "benchmarks" / folder.name, [inc.name for inc in increments]),
    )


def _increment(folder: Path) -> Increment:
    scene, growth = folder / "pictures" / "scene.json", folder / "growth.json"
    sizing, front, crack = (folder / name for name in ("sizing.npz", "sif.csv", "crack.vtp"))
    drawn = {name: folder / "pictures" / f"{name}.webp" for name in PICTURES}
    lengths = read_sizing(sizing) if sizing.is_file() else {}
    return Increment(
        name=folder.name,
        quality=_json(folder / "quality.json"),
        lengths={name: float(lengths[name]) for name in SIZES if lengths},
        front=_front(front),
        growth=_json(growth) if growth.is_file() else None,
        crack=read_crack(crack) if crack.is_file() else None,
        reaction=_reaction(folder / "solution.npz"),
        pictures={name: path.read_bytes() for name, path in drawn.items() if path.is_file()},
        scene=_json(scene) if scene.is_file() else None,
        digests=_digests(folder, ("model.inp", "model_mesh.inp", "volume.vtu")),
    )


def _front(path: Path) -> dict[str, np.ndarray] | None:
    """Return the columns of a sif.csv; None without one, and of a crack that has no front left."""
    if not path.is_file() or not front_table(path).rows:
        return None
    columns = read_front(path)
    flags = read_words(path, "flags") or [""] * len(columns["x"])
    return columns | {"flags": np.array(flags)}


def _reaction(path: Path) -> float | None:
    if not path.is_file():
        return None
    return float(np.abs(read_solution(path).reactions).sum(axis=0).max() / 2)


def _digests(folder: Path, names: tuple[str, ...]) -> dict[str, str]:
    found = {}
    for name in names:
        if (folder / name).is_file():
            with open(folder / name, "rb") as stream:
                found[name] = hashlib.file_digest(stream, "sha256").hexdigest()
    return found


def _json(path: Path) -> dict:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise CraftmeshError(f"{path}: not JSON ({error}); make it again") from None

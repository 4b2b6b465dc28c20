"""Reads an input deck back, with no code of the product."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

# Corners of the faces S1 to S4.
FACES = np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]])


@dataclass(frozen=True)
class DeckFile:
    """points (n, 3), tets (m, 4 or 10), grain (m,), node sets, surfaces as rows (tet, face)."""

    points: np.ndarray
    tets: np.ndarray
    grain: np.ndarray
    node_sets: dict[str, np.ndarray]
    surfaces: dict[str, np.ndarray]

    @property
    def corners(self) -> np.ndarray:
        return self.tets[:, :4]

    def lip(self, side: str) -> np.ndarray:
        """Return the triangles (k, 3) of the lips A or B of all cracks."""
        names = [
            name for name in self.surfaces if name.startswith("CRACK_") and name.endswith(f"LIP_{side}")
        ]
        return np.concatenate([np.zeros((0, 3), np.int64), *map(self.triangles, sorted(names))])

    def triangles(self, surface: str) -> np.ndarray:
        """Return the corner nodes (k, 3) of a surface's faces."""
        tet, face = self.surfaces.get(surface, np.zeros((0, 2), np.int64)).T
        return self.corners[tet[:, None], FACES[face]]


def read_deck(path: Path) -> DeckFile:
    """Return what a deck of C3D4 or C3D10 with sets GRAIN_<id> holds; raises ValueError for others."""
    blocks = _blocks(path)
    node = np.concatenate([_table(rows) for word, _, rows in blocks if word == "NODE"])
    ids = node[:, 0].astype(np.int64)
    place = np.full(ids.max() + 1, -1)
    place[ids] = np.arange(len(ids))
    elements, sets, tets, grain = [], {}, [], []
    for word, options, rows in blocks:
        if word == "ELEMENT":
            table = _table(rows).astype(np.int64)
            elements.append(table[:, 0])
            tets.append(table[:, 1:])
            grain.append(np.full(len(table), int(options["ELSET"].rpartition("_")[2])))
    element = np.concatenate(elements)
    row = np.full(element.max() + 1, -1)
    row[element] = np.arange(len(element))
    node_sets = {}
    for word, options, rows in blocks:
        if word == "NSET":
            node_sets[options["NSET"]] = place[_ids(rows)]
        elif word == "ELSET" and rows and rows[0].split(",")[0].strip().isdigit():
            sets[options["ELSET"]] = row[_ids(rows)]
    surfaces = {o["NAME"]: _surface(rows, sets) for word, o, rows in blocks if word == "SURFACE"}
    return DeckFile(node[:, 1:], place[np.concatenate(tets)], np.concatenate(grain), node_sets, surfaces)


def _surface(rows: list[str], sets: dict[str, np.ndarray]) -> np.ndarray:
    parts = [[word.strip() for word in line.split(",")] for line in rows]
    faces = [
        np.stack([sets[name], np.full(len(sets[name]), int(side[1]) - 1)], axis=1) for name, side in parts
    ]
    return np.concatenate(faces)


def _blocks(path: Path) -> list[tuple[str, dict[str, str], list[str]]]:
    lines = [line for line in path.read_text().splitlines() if not line.startswith("**")]
    starts = [number for number, line in enumerate(lines) if line.startswith("*")]
    blocks = []
    for start, end in zip(starts, [*starts[1:], len(lines)]):
        word, *options = [part.strip() for part in lines[start][1:].split(",")]
        pairs = dict(part.upper().partition("=")[::2] for part in options)
        blocks.append((word.upper(), pairs, lines[start + 1 : end]))
    return blocks


def _table(rows: list[str]) -> np.ndarray:
    return np.loadtxt(rows, delimiter=",", ndmin=2)


def _ids(rows: list[str]) -> np.ndarray:
    return np.array(",".join(rows).replace(" ", "").strip(",").replace(",,", ",").split(","), np.int64)

"""Cracks beyond one sheet over a plane: pairs, hooks that overhang, and cracks along grain boundaries."""

from collections import defaultdict
from dataclasses import replace

import numpy as np

from craftmesh.cracks.in_boundaries import crack_in_boundaries
from craftmesh.cracks.options import CrackOptions
from craftmesh.errors import CraftmeshError
from craftmesh.remeshing.remesh import remesh
from craftmesh.types import INTERFACE, Surface, Voxels
from trials.placing import draw_place
from trials.sheets import Relief, Sheet, disc, placed

KINDS = ("one", "pair", "overhang", "boundaries")
SHARES = (0.64, 0.14, 0.12, 0.1)
STREAM = 1  # beside the seed: what is drawn here leaves the rest of a case as it is
TRIES = 20  # places for a crack along boundaries, until one holds something


def draw_kind(rng: np.random.Generator) -> str:
    """Return which of KINDS a case has."""
    return str(rng.choice(KINDS, p=SHARES))


def pair(rng: np.random.Generator, voxels: Voxels, first: Sheet, l_min: float) -> tuple[Sheet, ...]:
    """Return the sheet and a disc somewhere else, which may cross it."""
    radius = float(rng.uniform(0.15, 0.35) * np.ptp(voxels.box, axis=0).min())
    _, centre, frame = draw_place(rng, voxels, False)
    flat = disc((radius, radius), Relief(lambda u, v: 0 * (u + v)), l_min)
    return first, placed(flat, centre, frame)


def hook(rng: np.random.Generator, voxels: Voxels, l_min: float) -> Sheet:
    """Return a strip from a face that turns by 70 to 110 degrees once or twice, so that it overhangs."""
    least = float(np.ptp(voxels.box, axis=0).min())
    _, centre, frame = draw_place(rng, voxels, True)
    sign = rng.choice([-1, 1])
    turns = np.radians([0.0, 0.0, *(sign * rng.uniform(70, 110, int(rng.integers(1, 3))))])
    if np.degrees(np.abs(turns).sum()) < 100:  # one plane would do
        turns[-1] = sign * np.radians(110.0)
    heading = np.cumsum(turns)
    steps = np.array([0.5 * least, *(rng.uniform(0.12, 0.25, len(turns) - 1) * least)])
    line = np.cumsum(steps[:, None] * np.column_stack([np.cos(heading), np.sin(heading)]), axis=0)
    line = np.concatenate([[[0.0, 0.0]], line]) - [steps[0], 0.0]
    width = 1.05 * float(np.linalg.norm(np.ptp(voxels.box, axis=0)))
    rows = np.linspace(-width, width, max(int(width / (4 * l_min)), 4))
    points = np.stack([np.column_stack([0 * rows + u, rows, 0 * rows + w]) for u, w in line])
    corner = (np.arange(len(line) - 1)[:, None] * len(rows) + np.arange(len(rows) - 1)).ravel()
    across = corner + len(rows)
    first = np.stack([corner, across, across + 1], axis=1)
    second = np.stack([corner, across + 1, corner + 1], axis=1)
    triangles = np.concatenate([first, second])
    return placed(Sheet(points.reshape(-1, 3), triangles, (points[-1],), False), centre, frame)


def boundaries(rng: np.random.Generator, voxels: Voxels) -> tuple[Sheet, CrackOptions] | None:
    """Return a crack along one boundary or the three of a triple line, and its options, if any."""
    surface = remesh(voxels)[0]
    groups = _groups(surface)
    for _ in range(TRIES if groups else 0):
        pairs, points = groups[int(rng.integers(len(groups)))]
        centre = surface.points[points[int(rng.integers(len(points)))]]
        options = CrackOptions(
            shape="boundaries",
            boundaries=tuple(f"{low}-{high}" for low, high in pairs),
            centre=tuple(map(float, centre)),
            radius=float(rng.uniform(0.12, 0.3) * np.ptp(voxels.box, axis=0).min()),
        )
        try:
            crack = crack_in_boundaries(surface, options, 0)
        except CraftmeshError:
            continue
        if len(crack.fronts) and len(crack.triangles) > 30:
            fronts = tuple(crack.points[front] for front in crack.fronts)
            return Sheet(crack.points, crack.triangles, fronts, False), options
    return None


def _groups(surface: Surface) -> list[tuple[tuple, list[int]]]:
    """Return pairs of grains that touch, one or three that meet in a line, and the points where they do."""
    inner = (surface.kind == INTERFACE) & (surface.sides > 0).all(axis=1)
    at: dict[int, set] = defaultdict(set)
    for corners, sides in zip(
        surface.facets[inner].tolist(), np.sort(surface.sides[inner], axis=1).tolist()
    ):
        for corner in corners:
            at[corner].add(tuple(sides))
    groups: dict[tuple, list[int]] = defaultdict(list)
    for point, pairs in at.items():
        if len(pairs) in (1, 3):
            groups[tuple(sorted(pairs))].append(point)
    return [item for item in sorted(groups.items()) if len(item[1]) > 4]


def together(sheets: tuple[Sheet, ...]) -> Sheet:
    """Return several sheets as one; their points stay apart."""
    shifts = np.cumsum([0, *(len(sheet.points) for sheet in sheets)])
    return replace(
        sheets[0],
        points=np.concatenate([sheet.points for sheet in sheets]),
        triangles=np.concatenate([sheet.triangles + shift for sheet, shift in zip(sheets, shifts)]),
        fronts=tuple(front for sheet in sheets for front in sheet.fronts),
        flat=False,
    )

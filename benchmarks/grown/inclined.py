"""The path of an inclined penny in a pulled cube, against one with half the edges and half the step.

One material with grain boundaries; each path is a campaign of its own.
"""

from pathlib import Path

import numpy as np
from measure import print_table

from grown.campaigns import Check, columns, front, grown

EDGE, RADIUS, GROWN = 40, 6.0, 5
CENTRE = np.array([20.2, 19.8, 20.1])
DEGREES = 30.0
LENGTH, STEP = 0.75, 1.5  # an eighth and a quarter of the radius
MOST_OFF, MOST_MODE_II = 0.05, 0.02  # found: 0.027 edges, 0.012
CONFIG = """
generate: {{shape: [{edge}, {edge}, {edge}], grains: 8}}
sizing: {{l0: {l0}, l_min: {length}, l_max: 8.0, r0: 3.0, r1: 12.0}}
cracks: {{crack: {{shape: penny, centre: {centre}, normal: {normal}, radius: {radius}}}}}
grow: {{extension: {step}}}
inp: {{material: ["isotropic:70000,0.3"], load: stress, magnitude: 1.0}}
"""
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


def inclined(folder: Path) -> list[Check]:
    """Grow the penny by GROWN steps and by twice as many half steps, and print how the paths differ."""
    coarse, fine = (campaign(folder / str(cut), cut) for cut in (1, 2))
    rows = compared(coarse, fine)
    print_table(rows, COLUMNS)
    last = rows[-1]
    return [
        Check("off the fine path, edges: most", max(row["off"][1] for row in rows[1:]), 0.0, MOST_OFF),
        Check("|K_II| / K_I at the end", last["mode_ii"], 0.0, MOST_MODE_II),
    ]


def campaign(folder: Path, halved: int) -> Path:
    """Let the penny grow GROWN steps, each cut in `halved`, and return the folder of its increments.

    The last crack is not grown from, but made as if it were: the step before it is then corrected too.
    """
    normal = [float(np.sin(np.radians(DEGREES))), 0.0, float(np.cos(np.radians(DEGREES)))]
    length = LENGTH / halved
    config = CONFIG.format(
        edge=EDGE,
        l0=max(1.0, 1.25 * length),
        length=length,
        centre=CENTRE.tolist(),
        normal=normal,
        radius=RADIUS,
        step=STEP / halved,
    )
    steps = GROWN * halved
    return grown(folder, config, steps + 2, f"{steps:03d}/base.vtp")


def meridians(case: Path, increment: int) -> np.ndarray:
    """Return where the front that an increment grows from meets the half planes AZIMUTHS (k, 2).

    Distances from the penny's axis, round which these are, and heights along it.
    """
    tilt = np.radians(DEGREES)
    axes = np.array([[np.cos(tilt), 0, -np.sin(tilt)], [0, 1, 0], [np.sin(tilt), 0, np.cos(tilt)]])
    places = (front(case, increment)[:-1] - CENTRE) @ axes.T
    turn = np.arctan2(places[:, 1], places[:, 0])
    values = np.column_stack([np.hypot(places[:, 0], places[:, 1]), places[:, 2]])
    return np.stack([np.interp(AZIMUTHS, turn, column, period=2 * np.pi) for column in values.T], axis=1)


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

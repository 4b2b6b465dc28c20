"""Cracks that grow out of the body: a penny through a face of the box, an edge crack into a hole."""

from pathlib import Path

import numpy as np

from grown import plate
from grown.campaigns import Check, columns, ended, front, grown, off_front, places

CENTRE, RADIUS, EDGE, STEPS = np.array([20.2, 7.3, 20.1]), 6.0, 0.75, 3
CONFIG = f"""
generate: {{shape: [40, 40, 40], grains: 4}}
sizing: {{l0: 1.0, l_min: {EDGE}, l_max: 8.0, r0: 3.0, r1: 12.0}}
cracks: {{crack: {{shape: penny, centre: {CENTRE.tolist()}, radius: {RADIUS}}}}}
grow: {{extension: {2 * EDGE}}}
inp: {{material: ["isotropic:70000,0.3"], load: stress, magnitude: 1.0}}
"""


def broken_through(folder: Path) -> list[Check]:
    """Grow a penny through the face y = 0 by its first step, and on from there."""
    case = grown(folder, CONFIG, STEPS + 1, f"{STEPS:03d}/sif.csv")
    found = [columns(case, step, "front.csv") for step in range(STEPS + 1)]
    ends = np.concatenate([each["y"][each["end"] > 0] for each in found[1:]])
    off = max(off_front(front(case, step, "crack"), places(each)) for step, each in enumerate(found))
    high = max(np.abs(front(case, step, "crack")[:, 2] - CENTRE[2]).max() for step in range(STEPS + 1))
    return [
        Check("ends of the fronts", float(len(ends)), 2.0 * STEPS, 0.0),
        Check("ends off the face", float(np.abs(ends).max()), 0.0, 0.0),
        Check("front's nodes off the crack's front, edges", off / EDGE, 0.0, 0.02),
        Check("front off its plane, edges", float(high) / EDGE, 0.0, 0.2),
    ]


def into_hole(folder: Path) -> list[Check]:
    """Grow an edge crack into a hole ahead of it, where it ends."""
    case = plate.campaign(folder, 3, hole=(20.0, 30.0), growth="until", depth=9.5)
    last = max(int(path.parent.name) for path in case.glob("*/growth.json"))
    why = ended(case, last)
    return [
        Check("ends after increment", float(last), 2.0, 0.0),
        Check("says that no front is left", float("front" in why), 1.0, 0.0),
    ]

"""An edge crack through a pulled plate: straight in a whole plate, drawn to a hole beside it.

The ends of the plate move apart evenly and the crack lies halfway: without a hole K_II and K_III are 0.
"""

from pathlib import Path

import numpy as np

from grown.campaigns import Check, columns, front, grown
from grown.inclined import distance_to_path

WIDTH, THICKNESS, VOXEL = 60.0, 6.0, 1.5
DEPTH, STEP = 9.0, 2.4
EDGE = 1.2  # five to the thickness, two to a step
CONFIG = """
import: {{background: void, allow_single_grain: true}}
sizing: {{l0: {l0}, l_min: {edge}, l_max: 8.0, r0: 4.0, r1: 20.0}}
cracks: {{crack: {{shape: through_edge, centre: [0.0, 3.0, 30.0], radius: {depth}}}}}
grow: {{extension: {step}}}
inp: {{material: ["isotropic:70000,{poisson}"], load: strain, magnitude: 0.001}}
"""
STRAIGHT = 8
# Times as much at the nodes on the free faces, from which growth takes no kink: K_II errs by up to 1.2 % of
# K_I there, and with Poisson's ratio neither K_II nor K_III has a limit at a face.
AT_END = 2.0
HOLE, RADIUS, BESIDE = (27.0, 40.0), 6.0, 4  # its axis in x and z, along y


def straight(folder: Path) -> list[Check]:
    """Grow the crack of a whole plate without Poisson's ratio, and with it."""
    return [check for poisson in (0.0, 0.3) for check in _straight(folder / f"nu_{poisson}", poisson)]


def hole(folder: Path) -> list[Check]:
    """Grow the crack beside the hole, and again with half the edges."""
    coarse, fine = (campaign(folder / str(cut), BESIDE, hole=HOLE, halved=cut) for cut in (1, 2))
    ours, theirs = (
        np.array([middle_and_ends(case, k) for k in range(BESIDE + 1)]) for case in (coarse, fine)
    )
    path = theirs[:, :1]
    path = np.concatenate([path, 2 * path[-1:] - path[-2:-1]])  # a point at its end may be ahead of it
    off = [distance_to_path(place[:1], path)[0] for place in ours[1:]]
    apart = [np.ptp(each[:, 1:, 1], axis=1).max() for each in (ours, theirs)]
    return [
        Check("off the path of half the edges, hole's radii", max(off) / RADIUS, 0.0, 0.1),
        *(
            Check(f"ends apart, thicknesses, edges of {EDGE / cut:.2g}", most / THICKNESS, 0.0, 0.05)
            for cut, most in zip((1, 2), apart)
        ),
    ]


def campaign(
    folder: Path,
    steps: int,
    poisson: float = 0.3,
    hole: tuple[float, float] | None = None,
    halved: int = 1,
    growth: str = "grow",
    depth: float = DEPTH,
) -> Path:
    """Return the increments of the crack in a plate; the step after the last corrects that one."""
    folder.mkdir(parents=True, exist_ok=True)
    np.savez(folder / "plate.npz", labels=_labels(hole), spacing=np.full(3, VOXEL))
    edge = EDGE / halved
    config = CONFIG.format(l0=1.25 * edge, edge=edge, step=STEP, poisson=poisson, depth=depth)
    target = f"{steps:03d}/base.vtp" if growth == "grow" else ""
    return grown(folder, config, steps + 2, target, growth, "plate.npz")


def middle_and_ends(case: Path, increment: int) -> np.ndarray:
    """Return x and z (3, 2) of the front that an increment grows from: in the middle, and at both ends."""
    points = front(case, increment)
    points = points[np.argsort(points[:, 1])]
    at = THICKNESS * np.array([0.5, 0.0, 1.0])
    return np.stack([np.interp(at, points[:, 1], points[:, axis]) for axis in (0, 2)], axis=1)


def _labels(hole: tuple[float, float] | None) -> np.ndarray:
    across, through = round(WIDTH / VOXEL), round(THICKNESS / VOXEL)
    x, z = VOXEL * (np.indices((across, across)) + 0.5)
    inside = np.ones(x.shape, bool) if hole is None else np.hypot(x - hole[0], z - hole[1]) > RADIUS
    return np.repeat(inside[:, None, :], through, axis=1).astype(np.int32)


def _straight(folder: Path, poisson: float) -> list[Check]:
    case = campaign(folder, STRAIGHT, poisson)
    found = [columns(case, step) for step in range(STRAIGHT + 1)]
    kink, tearing = ([np.abs(each[name]) for each in found] for name in ("kink_angle", "K_III"))
    tearing = [one / each["K_I"] for one, each in zip(tearing, found)]
    off = max(abs(front(case, step)[:, 2] - WIDTH / 2).max() for step in range(STRAIGHT + 1))
    checks = [Check(f"off the plane, edges, nu {poisson}", off / EDGE, 0.0, 0.05)]
    for where, rows, bound in (("off the ends", slice(1, -1), 1.0), ("at the ends", [0, -1], AT_END)):
        for what, each, most in (("|kink angle|, degrees", kink, 1.0), ("|K_III| / K_I", tearing, 0.01)):
            worst = max(float(one[rows].max()) for one in each)
            checks.append(Check(f"{what}, {where}, nu {poisson}", worst, 0.0, bound * most))
    return checks

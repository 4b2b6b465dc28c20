"""Flat cracks in tension by Paris' law, m = 3, in steps of a quarter of their size: a penny and an ellipse.

The body is ten times as wide as the last crack, so that K is that of an infinite one to 0.2 %.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.integrate import quad, solve_ivp
from scipy.special import ellipe

from grown.campaigns import Check, columns, front, grown, growth

CENTRE = np.array([100.3, 99.6, 100.2])
COEFFICIENT, STEPS = 1e-3, 4
RADIUS, AXES = 5.0, (8.0, 4.0)
PENNY = f"shape: penny, radius: {RADIUS}, centre: {CENTRE.tolist()}"
CONFIG = """
generate: {{shape: [40, 40, 40], spacing: [5.0, 5.0, 5.0], grains: 4}}
sizing: {{l0: 1.5, l_min: 0.6, l_max: 25.0, r0: 4.0, r1: 40.0}}
cracks: {{crack: {{{crack}}}}}
grow: {{{grow}}}
inp: {{material: ["isotropic:70000,0.3"], load: stress, magnitude: {stress}, lip_friction: {friction}}}
"""


def penny(folder: Path) -> list[Check]:
    """Grow a penny: cycles, and how round it stays."""
    case = _grown(folder, PENNY)
    away = np.linalg.norm(front(case, STEPS) - CENTRE, axis=1)
    radius = float(away.mean())
    exact = quad(lambda a: 1 / (COEFFICIENT * (2 * np.sqrt(a / np.pi)) ** 3), RADIUS, radius)[0]
    found = growth(case, STEPS)["cycles"]
    return [
        Check("cycles over the exact ones", found / exact, 1.0, 0.01),
        Check("radius off its mean, share", float(np.abs(away / radius - 1).max()), 0.0, 0.002),
        Check("|kink angle|, degrees", float(np.abs(columns(case, STEPS)["kink_angle"]).max()), 0.0, 1.0),
    ]


def ellipse(folder: Path) -> list[Check]:
    """Grow an ellipse, and hold its axes against the equations of both axes' ends with Irwin's K."""
    a, b = AXES
    case = _grown(folder, f"shape: ellipse, semi_axes: [{a}, {b}], centre: {CENTRE.tolist()}")
    axes = [_semi_axes(front(case, step)) for step in range(1, STEPS + 1)]
    path = _path(lambda b, a: (b / a[0]) ** 1.5, b, axes[-1][1], a)
    exact = [b / path(b)[0] for _, b in axes]
    cycles = quad(lambda b: 1 / (COEFFICIENT * _at_lesser(b, path(b)[0]) ** 3), b, axes[-1][1])[0]
    found = growth(case, STEPS)["cycles"]
    checks = [
        Check(f"b / a over that of the axes' path, step {step}", b / a / known, 1.0, 0.01)
        for step, ((a, b), known) in enumerate(zip(axes, exact), 1)
    ]
    # Found: 1.5 %. The path is that of a crack that stays an ellipse; this one lags by 1.0 % between its
    # axes after a step, and K at its nearer ends is 0.7 % under Irwin's, with edges of 0.6 and of 0.4.
    return [*checks, Check("cycles over those of the axes' path", found / cycles, 1.0, 0.02)]


def in_large_body(crack: str, grow: str, stress: float = 1.0, friction: float = 0.0) -> str:
    """Return the configuration of a crack near CENTRE in a body under a stress along z."""
    return CONFIG.format(crack=crack, grow=grow, stress=stress, friction=friction)


def _grown(folder: Path, crack: str) -> Path:
    """Return the increments of a case: the step after the last that is looked at corrects that one."""
    law = f"law: power, share: 0.25, coefficient: {COEFFICIENT}"
    return grown(folder, in_large_body(crack, law), STEPS + 2, f"{STEPS:03d}/base.vtp")


def _semi_axes(points: np.ndarray) -> tuple[float, float]:
    """Return half of how far points (n, 3) reach along x and y."""
    along_x, along_y = np.ptp(points[:, :2], axis=0) / 2
    return float(along_x), float(along_y)


def _path(slope: Callable, start: float, end: float, value: float) -> Callable:
    return solve_ivp(slope, (start, end), [value], dense_output=True, rtol=1e-9).sol


def _at_lesser(b: float, a: float) -> float:
    """Return Irwin's K_I at the end of the lesser semi-axis in unit tension."""
    return float(np.sqrt(np.pi * b) / ellipe(1 - (b / a) ** 2))

"""The stages in which a surface gives way to flat, poor and stretched tets: how far, and for what."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from craftmesh.mesh.poor import is_flat, is_poor
from craftmesh.tetrahedra.kernels.tet_faults import OF_FLAT, OF_POOR, SOUND_FROM
from craftmesh.tetrahedra.kernels.tet_quality import FORM, POOR, WHOLE, WIDE, Aim


@dataclass(frozen=True)
class Stage:
    """Which tets the surface gives way to, by `shape_measures`, and how far.

    reaches: nodes of the surface move by at most these parts of the mean edge at them, round by round, as
    long as there are such tets: what a small move opens is not opened by a large one. aim: what moves
    raise, and how far (`tet_quality`); None: they lower what tets weigh (`tet_faults`). score: what tets
    have after a contraction, 0 at the limits of flat and 1 at those of poor ones; None: nothing contracts.
    drift: no move changes a volume by more than this part; nodes of one that has changed by more stay.
    """

    is_bad: Callable[[np.ndarray], np.ndarray]
    reaches: tuple[float, ...]
    aim: Aim | None
    score: float | None
    drift: float = np.inf


# The aspect ratio that no tet should have.
STRETCHED = 5.0
# Degrees: the least dihedral angle of tets where no facet has a smaller one.
NARROW = 15.0
# What a narrow tet weighs where a stretched one weighs 1.
OF_NARROW = 0.01


def is_stretched(measures: np.ndarray) -> np.ndarray:
    """Return (m,) bool: tets of an aspect ratio over STRETCHED, from `shape_measures` (m, 5)."""
    return measures[:, 1] > STRETCHED


def is_at_fault(measures: np.ndarray) -> np.ndarray:
    """Return (m,) bool: tets that are flat, poor or stretched."""
    return is_poor(measures) | is_stretched(measures)


def is_narrow(measures: np.ndarray) -> np.ndarray:
    """Return (m,) bool: tets with a dihedral angle under NARROW, from `shape_measures` (m, 5)."""
    return measures[:, 2] < NARROW


def weighed_faults(measures: np.ndarray) -> float:
    """Return the number of flat, poor, stretched and narrow tets, by their weights (`tet_faults`)."""
    flat, poor, stretched, narrow = (
        np.count_nonzero(is_bad(measures)) for is_bad in (is_flat, is_poor, is_stretched, is_narrow)
    )
    return OF_FLAT * flat + OF_POOR * poor + stretched + OF_NARROW * narrow


# Rounds go as far as the one before leaves such tets. Where edges grow from 0.5 to 15 in grains 8 across,
# .67 % of 29,000 tets were stretched; .01 % after 266 of 3,060 points had moved by 0.15. Of four random
# cracks with 5, 31, 51 and 57 stretched tets that 0.15 had left, 0, 30, 2 and 3 are left with 0.4.
REACHES = (0.025, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4)
# How far volumes of grains and voids may drift for stretched tets. A grain of 600 voxels among edges as
# long as it is had changed by 8 %.
MOST_DRIFT = 0.05
STAGES = (
    Stage(is_flat, REACHES, Aim(FORM, POOR), 0.0),
    Stage(is_poor, REACHES, Aim(FORM, POOR), 1.0),
    Stage(is_stretched, REACHES, Aim(WHOLE, SOUND_FROM), None, MOST_DRIFT),
    Stage(is_at_fault, REACHES, None, None, MOST_DRIFT),
)
# Last, small moves for narrow tets. Of 1,470,000 tets one of 14.5 degrees was left, with all corners on the
# surface.
AT_NARROW = Stage(is_narrow, REACHES[:3], Aim(FORM, WIDE), None, 0.01)
# Before any moves: no score is enough but that of nodes that touch, which become one.
JOINING = Stage(is_flat, (), Aim(FORM, POOR), np.inf)

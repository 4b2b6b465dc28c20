"""Options of growth: direction, extension and smoothing of the front points' moves."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from craftmesh.errors import CraftmeshError
from craftmesh.options import Options, option, own_code

NEAR_FIELD, SLIP = "near_field", "slip"
CRITERIA = ("tangential_stress", "energy_release", NEAR_FIELD, SLIP)
LEAST_RATIO = -2.0  # smallest stress ratio R that Newman's opening function covers
# Smallest and largest rate, in median rates. Both hold where da/dN is not known in its unit (`limits`);
# MOST also shortens steps (`steps.step_length`).
LEAST, MOST = 0.2, 2.0


@dataclass(frozen=True)
class GrowthOptions(Options):
    """Kink angles and extensions from the stress intensities along a front; lengths in model units."""

    criterion: str = option(
        "tangential_stress",
        "kink angle: tangential_stress (Erdogan & Sih), energy_release, near_field (largest stress in the "
        "crystal), slip (along the most active plane in slip_table), or package.module:function",
    )
    slip_table: str = option(
        "",
        "CSV of the slip around this increment's front, for criterion slip: columns x,y,z and slip_hkl of "
        "each crystal plane, such as slip_111 and slip_1-11, or one column slip for all {111} planes",
    )
    ring: float = option(
        2.0, "radius of the ring around the front on which slip is read, in local front edges", above=0
    )
    law: Literal["uniform", "power"] = option(
        "uniform", "extension: uniform, or power (it follows da/dN at each point's Delta K)"
    )
    change: float = option(
        0.1, "relative change of K per step if neither share nor extension is given", above=0, at_most=1
    )
    share: float | None = option(
        None, "median extension as a fraction of the crack's size, in place of change", above=0
    )
    extension: float | None = option(None, "median extension; overrides share", "model units", above=0)
    exponent: float = option(3.0, "exponent m of Delta K in the power law and in Paris' law", at_least=0)
    rates: tuple[str, ...] = option(
        (),
        "da/dN laws in place of coefficient, exponent and threshold: paris:C,m or paris:C,m,THRESHOLD or "
        "table:DELTA_K,RATE,DELTA_K,RATE,...; put PHASE= or GRAIN_<id>= before a law of one phase or grain",
    )
    closure: str = option(
        "none", "fraction of a cycle in which the crack is open: none, open:U, or newman:ALPHA,SMAX"
    )
    coefficient: float | None = option(
        None, "C of Paris' law da/dN = C Delta K^m; with it load cycles are counted", above=0
    )
    stress_ratio: float = option(
        0.0, "stress ratio R: smallest over largest load of a cycle", at_least=LEAST_RATIO, below=1
    )
    cycle: tuple[str, ...] = option(
        (),
        "load cases or sums of them (inp.combine) at the largest and the smallest load of a cycle; the "
        "second replaces stress_ratio",
    )
    threshold: float = option(
        0.0, "front points whose Delta K is not above this value stay where they are", at_least=0
    )
    poisson: float = option(
        0.3, "Poisson's ratio that weighs mode III in energy_release", above=-1, below=0.5
    )

    def __post_init__(self) -> None:
        """Raise CraftmeshError for values out of bounds, and for options that contradict each other."""
        super().__post_init__()
        if len(self.cycle) > 2 or len(set(self.cycle)) < len(self.cycle):
            raise CraftmeshError(
                f"cycle is {', '.join(self.cycle)}; name the largest load, or the largest and another one"
            )
        if (self.criterion == SLIP) != bool(self.slip_table):
            raise CraftmeshError(
                f"criterion is {self.criterion} and slip_table {self.slip_table!r}; give a slip_table with "
                "criterion slip, and none with any other"
            )
        if len(self.cycle) == 2 and self.stress_ratio:
            raise CraftmeshError(
                f"cycle names {self.cycle[1]!r} as the smallest load, but stress_ratio is "
                f"{self.stress_ratio:g}; remove one of the two"
            )

    @property
    def has_rates(self) -> bool:
        """True if da/dN is known in its unit, so that load cycles are counted."""
        return self.coefficient is not None or bool(self.rates)

    @property
    def limits(self) -> tuple[float, float]:
        """Smallest and largest rate of a point, in median rates; no limits where `has_rates`."""
        return (0.0, math.inf) if self.has_rates else (LEAST, MOST)


@dataclass(frozen=True)
class SmoothingOptions(Options):
    """Smoothing of the front points' moves along the front."""

    smoothing: Literal["fit", "savitzky_golay", "none"] = option(
        "fit", "smoothing of the extension along the front"
    )
    window: int = option(7, "front nodes in the window of savitzky_golay, an odd number", at_least=5)


@dataclass(frozen=True)
class CorrectionOptions(Options):
    """Correction of a step to the chord of the crack's path, instead of the path's first tangent."""

    correct: bool = option(
        True, "before each new strip, lay the last one again, turned by half of the kink found at its end"
    )


def check_cycle(cycle: Sequence[str], loads: Sequence[str]) -> None:
    """Raise CraftmeshError if the cycle names a load case that is not in `loads`."""
    for name in cycle:
        if name not in loads:
            known = ", ".join(filter(None, loads)) or "none, name load cases in inp.faces"
            raise CraftmeshError(f"cycle: unknown load case {name!r}; known: {known}")


def check_criterion(name: str) -> None:
    """Raise CraftmeshError unless `name` is in CRITERIA or names a user-supplied function."""
    if name not in CRITERIA:
        own_code("criterion", name, CRITERIA)

"""Options of the growth: which way and how far each point of a front goes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from craftmesh.errors import CraftmeshError
from craftmesh.options import Options, option, own_code

NEAR_FIELD, SLIP = "near_field", "slip"
CRITERIA = ("tangential_stress", "energy_release", NEAR_FIELD, SLIP)
LAWS = ("uniform", "power")
LEAST_RATIO = -2.0  # of Newman's opening function
LEAST, MOST = 0.2, 2.0  # extensions over the median, of rates that are not known in their unit
SMOOTHING = ("fit", "savitzky_golay", "none")


@dataclass(frozen=True)
class GrowthOptions(Options):
    """Kink angles and extensions from the stress intensities along a front; lengths in model units."""

    criterion: str = option(
        "tangential_stress",
        "kink angle: tangential_stress (Erdogan & Sih), energy_release, near_field (that of the "
        "crystal), slip (along the plane that slips most in slip_table), or package.module:function",
    )
    slip_table: str = option(
        "",
        "csv of the slip round the front of this increment, for criterion slip: columns x,y,z, and "
        "slip_hkl of planes of the crystal, as slip_111, slip_1-11, or slip of all of {111}",
    )
    ring: float = option(
        2.0, "radius of the ring round the front on which slip is read, over the front's edges", above=0
    )
    law: str = option(
        "uniform", "extension: the same all along, or as da/dN, a power of Delta K", choices=LAWS
    )
    change: float = option(
        0.1, "step: the share by which K changes over it, where it is not given", above=0, at_most=1
    )
    share: float | None = option(
        None, "median extension in place of that, as a share of the crack's size", above=0
    )
    extension: float | None = option(None, "median extension in place of both", "model units", above=0)
    exponent: float = option(3.0, "power m of Delta K, in the power law and in Paris' law", at_least=0)
    rates: tuple[str, ...] = option(
        (),
        "da/dN in place of coefficient, exponent and threshold: paris:C,m or paris:C,m,THRESHOLD or "
        "table:DELTA_K,RATE,DELTA_K,RATE,...; PHASE= or GRAIN_<id>= before it where it is not for all",
    )
    closure: str = option(
        "none", "share of a cycle in which the crack is open: none, open:U, or newman:ALPHA,SMAX"
    )
    coefficient: float | None = option(
        None, "C of Paris' law da/dN = C Delta K^m: load cycles are then counted", above=0
    )
    stress_ratio: float = option(
        0.0, "least over largest load of a cycle, R", at_least=LEAST_RATIO, below=1
    )
    cycle: tuple[str, ...] = option(
        (),
        "load cases or sums of them (inp.combine) at the largest and the least load of a cycle, the second "
        "in place of stress_ratio",
    )
    threshold: float = option(
        0.0, "points of the front where Delta K is not over this stay where they are", at_least=0
    )
    poisson: float = option(
        0.3, "Poisson's ratio that weighs mode III in energy_release", above=-1, below=0.5
    )

    def __post_init__(self) -> None:
        """Raise CraftmeshError for values out of bounds, and for a cycle that is none."""
        super().__post_init__()
        if len(self.cycle) > 2 or len(set(self.cycle)) < len(self.cycle):
            raise CraftmeshError(
                f"cycle is {', '.join(self.cycle)}; expected the largest load, or it and the least"
            )
        if (self.criterion == SLIP) != bool(self.slip_table):
            raise CraftmeshError(
                f"criterion is {self.criterion} and slip_table {self.slip_table!r}; expected slip and "
                "a table, or neither"
            )
        if len(self.cycle) == 2 and self.stress_ratio:
            raise CraftmeshError(
                f"cycle names {self.cycle[1]!r} as the least load, and stress_ratio is "
                f"{self.stress_ratio:g}; keep one"
            )

    @property
    def has_rates(self) -> bool:
        """Whether da/dN is known in its unit, and cycles are counted."""
        return self.coefficient is not None or bool(self.rates)

    @property
    def limits(self) -> tuple[float, float]:
        """The smallest and the largest rate over the median that a point may have; da/dN is as it is."""
        return (0.0, math.inf) if self.has_rates else (LEAST, MOST)


@dataclass(frozen=True)
class SmoothingOptions(Options):
    """How the moves of a front's points are made smooth along it."""

    smoothing: str = option("fit", "smoothing of the extension along the front", choices=SMOOTHING)
    window: int = option(7, "front nodes in the window of savitzky_golay, an odd number", at_least=5)


@dataclass(frozen=True)
class CorrectionOptions(Options):
    """Whether a step counts as a chord of the path, not as its direction at the start."""

    correct: bool = option(
        True, "lay each strip again, turned by half of the kink found at its end, before the next one"
    )


def check_cycle(cycle: Sequence[str], loads: Sequence[str]) -> None:
    """Raise CraftmeshError for a cycle of other loads than those that have names."""
    for name in cycle:
        if name not in loads:
            known = ", ".join(filter(None, loads)) or "none: name load cases in inp.faces"
            raise CraftmeshError(f"cycle names {name!r}; expected loads of {known}")


def check_criterion(name: str) -> None:
    """Raise CraftmeshError unless `name` is one of CRITERIA, or names a function of one's own."""
    if name not in CRITERIA:
        own_code("criterion", name, CRITERIA)

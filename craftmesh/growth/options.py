"""Options of growth: direction, extension and smoothing of the front points' moves."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

from craftmesh.errors import CraftmeshError
from craftmesh.options import Options, import_user_callable, option

STRESS, NEAR_FIELD, SLIP = "tangential_stress", "near_field", "slip"
ACCUMULATED, FATEMI_SOCIE, ENERGY = "slip", "fatemi_socie", "energy"
# Largest kink angle tried for the tangential stress, degrees; isotropic, it peaks at 70.5 in pure mode II.
WIDEST_IN_CRYSTALS = 110.0
CRITERIA = (STRESS, "energy_release", "richard", "straight", NEAR_FIELD, SLIP)
DRIVING = (STRESS, "K_I", "energy_release", "richard", "tanaka")
LAWS = ("uniform", "power")
LEAST_RATIO = -2.0  # smallest stress ratio R that Newman's opening function covers
# Smallest and largest rate of a point, relative to the median rate. Both hold if da/dN is not known in its
# unit (`limits`); MOST also shortens steps (`steps.step_length`).
LEAST, MOST = 0.2, 2.0


class Block(NamedTuple):
    """Identical load cycles: their number, and a pair (factor, load case) for their two ends.

    The load is the factor times the load case; the load case "" is the first one.
    """

    number: float
    largest: tuple[float, str]
    smallest: tuple[float, str]

    @property
    def ratio(self) -> float | None:
        """The stress ratio R, smallest over largest factor; None if the ends are of two load cases."""
        (most, one), (least, other) = self.largest, self.smallest
        return least / most if one == other else None


@dataclass(frozen=True)
class GrowthOptions(Options):
    """Options of growth: how K along a front gives kink angles and extensions; lengths in model units."""

    criterion: str = option(
        STRESS,
        "kink angle: tangential_stress (Erdogan & Sih), energy_release, richard, straight (0), near_field "
        "(largest stress in the crystal), slip (along the most active plane in slip_table), or "
        "package.module:function",
    )
    driving: str = option(
        STRESS,
        "force whose range is Delta K: tangential_stress (at the kink angle, in the crystal with criterion "
        "near_field), K_I, energy_release (of all modes), richard, tanaka, or package.module:function",
    )
    slip_table: str = option(
        "",
        "CSV of the slip around this increment's front, for criterion slip: columns x,y,z and slip_hkl of "
        "each crystal plane, such as slip_111 and slip_1-11, or slip_hkl_uvw of each slip system, or one "
        "column slip for all {111} planes",
    )
    slip_parameter: Literal["slip", "fatemi_socie", "energy"] = option(
        ACCUMULATED,
        "what makes a plane of slip_table active: slip (the columns as they are), fatemi_socie (slip and "
        "normal stress), energy (shear stress times slip); both also need columns sxx to syz",
    )
    fatemi_socie_k: float | None = option(
        None, "k, weight of the normal stress in slip_parameter fatemi_socie", at_least=0
    )
    cyclic_yield_stress: float | None = option(
        None, "yield stress in slip_parameter fatemi_socie, in the unit of the table's stress", above=0
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
        "da/dN laws in place of coefficient, exponent and threshold: paris, walker, forman, nasgro, table, "
        "table_of_ratios with :CONSTANTS (docs/theory.md), or package.module:function; put PHASE= or "
        "GRAIN_<id>= before a law of one phase or grain",
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
    blocks: tuple[str, ...] = option(
        (),
        "table of load cycles in place of cycle and stress_ratio, repeated without end: rows of "
        "CYCLES,LARGEST,SMALLEST; a load is a factor on the first load, a load case, or FACTOR*CASE",
    )
    block_table: str = option(
        "",
        "CSV of such rows in place of blocks: columns cycles, largest and smallest; or with the column "
        "load, a load history, which rainflow counts",
    )
    toughness: float | None = option(
        None, "K_c: growth ends where the driving force at the largest load reaches it", above=0
    )
    yield_stress: float | None = option(
        None, "growth ends if the mean stress over the net section reaches it", above=0
    )
    threshold: float = option(
        0.0, "front points whose Delta K is not above this value stay where they are", at_least=0
    )
    poisson: float = option(
        0.3, "Poisson's ratio that weighs mode III in energy_release and tanaka", above=-1, below=0.5
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
        if self.slip_parameter != ACCUMULATED and self.criterion != SLIP:
            raise CraftmeshError(
                f"slip_parameter is {self.slip_parameter}, but criterion is {self.criterion}; use "
                "criterion slip, or remove slip_parameter"
            )
        constants = self.fatemi_socie_k, self.cyclic_yield_stress
        if constants.count(None) != (0 if self.slip_parameter == FATEMI_SOCIE else len(constants)):
            raise CraftmeshError(
                f"slip_parameter is {self.slip_parameter}, fatemi_socie_k {constants[0]} and "
                f"cyclic_yield_stress {constants[1]}; give both numbers with slip_parameter fatemi_socie, "
                "and neither with any other"
            )
        loads = [key for key in ("blocks", "block_table", "cycle", "stress_ratio") if getattr(self, key)]
        if len(loads) > 1 and loads[0] in ("blocks", "block_table"):
            raise CraftmeshError(
                f"{loads[0]} is given together with {loads[1]}; remove one, rows of blocks contain their "
                "own loads"
            )
        self.cycles()
        if len(self.cycle) == 2 and self.stress_ratio:
            raise CraftmeshError(
                f"cycle names {self.cycle[1]!r} as the smallest load, but stress_ratio is "
                f"{self.stress_ratio:g}; remove one of the two"
            )

    def cycles(self) -> tuple[Block, ...]:
        """Return the load cycles in the rows of `blocks`, or else one cycle by `cycle` and `stress_ratio`.

        Raise CraftmeshError for a row of another form, and if a row of one load case has a largest factor
        <= 0 or a stress ratio out of bounds.
        """
        if not self.blocks:
            first, second = (*self.cycle, "", "")[:2]
            other = (1.0, second) if second else (self.stress_ratio, first)
            return (Block(1.0, (1.0, first), other),)
        return tuple(_block(row) for row in self.blocks)

    @property
    def loads(self) -> tuple[str, ...]:
        """The load cases that the load cycles name, in order."""
        ends = (load for block in self.cycles() for load in (block.largest, block.smallest))
        return tuple(dict.fromkeys(name for _, name in ends if name))

    @property
    def has_rates(self) -> bool:
        """True if the options give da/dN in length per cycle, so that load cycles are counted.

        Otherwise only the ratios of the points' rates are known.
        """
        return self.coefficient is not None or bool(self.rates)

    @property
    def limits(self) -> tuple[float, float]:
        """Smallest and largest rate of a point, in median rates; no limits where `has_rates`."""
        return (0.0, math.inf) if self.has_rates else (0.0 if self.threshold else LEAST, MOST)


@dataclass(frozen=True)
class SmoothingOptions(Options):
    """Smoothing of the front points' moves along the front."""

    smoothing: Literal["fit", "savitzky_golay", "none"] = option(
        "fit", "smoothing of the extension along the front"
    )
    window: int = option(7, "front nodes in the window of savitzky_golay, an odd number", at_least=5)


@dataclass(frozen=True)
class CorrectionOptions(Options):
    """Option to correct the last step, so that it follows the chord of the path, not its first tangent."""

    correct: bool = option(
        True,
        "before each new strip, lay the last one again, turned by up to half of the kink found at its end",
    )


def _block(row: str) -> Block:
    """Return the load cycles in a row of `blocks`; raise CraftmeshError for a row of another form."""
    try:
        count, *loads = row.split(",")
        block = Block(float(count), *map(_load, loads))
        ratio = block.ratio
        ratio_fits = ratio is None or (block.largest[0] > 0 and LEAST_RATIO <= ratio < 1)
        if not (0 < block.number < math.inf and ratio_fits):
            raise ValueError
    except (ValueError, TypeError):
        raise CraftmeshError(
            f"blocks: {row!r} is no row; write CYCLES,LARGEST,SMALLEST with CYCLES > 0, and a factor, CASE "
            f"or FACTOR*CASE for each load; within one case LARGEST > 0 and {LEAST_RATIO:g} <= R < 1"
        ) from None
    return block


def _load(text: str) -> tuple[float, str]:
    """Return factor and load case of a text such as 0.5, peak or 0.5*peak.

    Raise ValueError if the factor is no finite number.
    """
    factor, star, name = text.strip().rpartition("*")
    if not star:
        try:
            factor, name = str(float(name)), ""
        except ValueError:
            factor = "1"
    if not math.isfinite(float(factor)):
        raise ValueError
    return float(factor), name.strip()


def check_cycle(options: GrowthOptions, loads: Sequence[str]) -> None:
    """Raise CraftmeshError if the load cycles name a load case that is not in `loads`."""
    for name in options.loads:
        if name not in loads:
            known = ", ".join(filter(None, loads)) or "none, name load cases in inp.faces"
            key = "blocks" if options.blocks else "cycle"
            raise CraftmeshError(f"{key}: unknown load case {name!r}; known: {known}")


def check_own(options: GrowthOptions) -> None:
    """Raise CraftmeshError unless criterion and driving are built in or name functions that exist."""
    for key, name, known in (
        ("criterion", options.criterion, CRITERIA),
        ("driving", options.driving, DRIVING),
    ):
        if name not in known:
            import_user_callable(key, name, known)

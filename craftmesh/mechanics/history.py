"""The history of a load: steps in which it goes to a level, or cycles between a peak and a valley.

A level is the factor by which a load, a load case or a sum of load cases, is multiplied.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.faces import named_numbers
from craftmesh.surface.rounding import ROUNDING

RAMP, TRIANGLE, SINE = "ramp", "triangle", "sine"
_EXPECTED = (
    "expected ramp:LEVEL, triangle:PEAK or sine:PEAK, then any of time=, increments=, and for cycles R=, "
    "cycles=, separated by commas; NAME/ in front names a load case or a sum"
)
_MOMENT = 1e-6  # duration of a hold, relative to the time of the step before; nothing creeps in it
_DIGITS = 12  # decimals to which levels are rounded, so that a level of zero is exactly 0


@dataclass(frozen=True)
class LoadStep:
    """One step of a load: a ramp or cycles.

    load: name of the load, "" if there is only one; kind: RAMP, TRIANGLE or SINE; level: factor of the load
    at the end of a ramp or at the peak of a cycle; R: level of the valley over that of the peak; cycles:
    number of cycles, may be a fraction; time: duration of the ramp or of one cycle; increments: smallest
    number of solver increments in a ramp or a cycle; start: the level before the step.
    """

    load: str
    kind: str
    level: float
    R: float = 0.0
    cycles: float = 1.0
    time: float = 1.0
    increments: float = 20.0
    start: float = 0.0

    @property
    def duration(self) -> float:
        """The duration of the step."""
        return self.time if self.kind == RAMP else self.time * self.cycles

    @property
    def end(self) -> float:
        """The level (factor of the load) at the end of the step."""
        return self.level if self.kind == RAMP else float(self.levels(np.array([self.cycles]))[0])

    def levels(self, cycles: np.ndarray) -> np.ndarray:
        """Return the levels (k,) after numbers of cycles (k,), which begin at `start` towards the peak.

        Only for steps of cycles, not for ramps.
        """
        phase = np.arcsin(self._share) if self.kind == SINE else np.pi / 2 * self._share
        sine = np.sin(2 * np.pi * cycles + phase)
        wave = sine if self.kind == SINE else 2 / np.pi * np.arcsin(np.clip(sine, -1, 1))
        return self.level * ((1 + self.R) / 2 + (1 - self.R) / 2 * wave)

    @property
    def _share(self) -> float:
        """Position of `start` between the valley (-1) and the peak (1)."""
        share = (2 * self.start / self.level - (1 + self.R)) / (1 - self.R)
        return min(max(share, -1.0), 1.0)

    def pieces(self) -> list["LoadStep"]:
        """Return the steps of a deck for this step: itself, or ramps between the turns of triangles.

        Increments of a solver end with each ramp, and so exactly at the turning points.
        """
        if self.kind != TRIANGLE:
            return [self]
        table = self.table().tolist()
        return [
            LoadStep(
                self.load,
                RAMP,
                level,
                0.0,
                1.0,
                later - before,
                self.increments * (later - before) / self.time,
                start,
            )
            for (before, start), (later, level) in zip(table, table[1:])
        ]

    def table(self) -> np.ndarray:
        """Return times and levels (k, 2) of a step of cycles; levels between them are linear.

        Triangles have their turning points and ends, sines at least as many intervals per cycle as
        increments. Not for ramps.
        """
        if self.kind == SINE:
            cycles = np.linspace(0, self.cycles, int(np.ceil(self.cycles * self.increments)) + 1)
        else:
            first = (1 - self._share) / 4
            turns = first + np.arange(np.ceil(2 * self.cycles)) / 2
            inside = turns[(turns > ROUNDING) & (turns < self.cycles - ROUNDING)]
            cycles = np.concatenate([[0.0], inside, [self.cycles]])
        return np.column_stack([cycles * self.time, self.levels(cycles).round(_DIGITS) + 0.0])


def parse_steps(texts: Iterable[str], loads: Sequence[str]) -> tuple[LoadStep, ...]:
    """Return the steps of texts such as "ramp:0.5", "triangle:1,R=-1,cycles=3" or "shear/sine:1,time=10".

    loads: names of the load cases and of their sums, empty if there is one load. Each step continues where
    the step before it ended. Raises CraftmeshError for texts of another form, for unknown loads, and for
    cycles that begin outside their own range or while another load acts.
    """
    found: list[LoadStep] = []
    for text in texts:
        step = _step(text)
        if step.load not in (loads or [""]):
            known = f"one of {', '.join(loads)} before the slash" if loads else "no name: there is one load"
            raise CraftmeshError(f"steps: {text!r} names load {step.load!r}; expected {known}")
        before = found[-1] if found else None
        if before is not None and (before.load == step.load or step.kind == RAMP):
            step = replace(step, start=before.end if before.load == step.load else 0.0)
        elif before is not None and abs(before.end) > ROUNDING:
            raise CraftmeshError(
                f"steps: {text!r} begins cycles of {step.load} while {before.load} is at {before.end:g}; "
                f"put {step.load}/ramp:LEVEL before it, which replaces the other load"
            )
        if step.kind != RAMP:
            low, high = sorted((step.level, step.level * step.R))
            room = ROUNDING * max(abs(low), abs(high))
            if not low - room <= step.start <= high + room:
                raise CraftmeshError(
                    f"steps: {text!r} cycles from {low:g} to {high:g}, but the load is at {step.start:g} "
                    f"when it begins; put a ramp to {step.level * step.R:g} before it"
                )
        found.append(step)
    return tuple(found)


def held_step(last: LoadStep) -> LoadStep:
    """Return a short step that holds the load at the level where step `last` ended."""
    return LoadStep(last.load, RAMP, last.end, time=_MOMENT * last.time, increments=1)


def _step(text: str) -> LoadStep:
    head, *others = (part.strip() for part in text.split(","))
    load, _, what = head.rpartition("/")
    kind, _, level = (part.strip() for part in what.partition(":"))
    values = named_numbers([f"level={level}", *others])
    allowed = {field.name for field in fields(LoadStep)[2:-1]}
    allowed -= {"R", "cycles"} if kind == RAMP else set()
    if (
        kind not in (RAMP, TRIANGLE, SINE)
        or values is None
        or not values.keys() <= allowed
        or min(values.get(key, 1.0) for key in ("cycles", "time", "increments")) <= 0
        or (kind != RAMP and not (values["level"] and values.get("R", 0.0) < 1))
    ):
        raise CraftmeshError(f"steps: {text!r}; {_EXPECTED}")
    return LoadStep(load.strip(), kind, **values)

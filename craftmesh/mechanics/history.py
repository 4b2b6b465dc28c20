"""The history of a load: steps in which it goes to a level, or up and down in cycles."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.faces import named_numbers
from craftmesh.surface.rounding import ROUNDING

RAMP, TRIANGLE, SINE = "ramp", "triangle", "sine"
_EXPECTED = (
    "expected ramp:LEVEL, triangle:PEAK or sine:PEAK, then any of time=, increments=, and for cycles R=, "
    "cycles=, with commas between; NAME/ before it for a load case or a sum"
)
_MOMENT = 1e-6  # of a step's time: what the load is held for, in which nothing creeps
_DIGITS = 12  # of a level, so that one of 0 is 0


@dataclass(frozen=True)
class LoadStep:
    """One step: `kind` of change, of the load called `load`, "" where there is one.

    level: times the load, at the end of a ramp or at the peak of a cycle; R: valley over peak; time: of the
    ramp or of a cycle; increments: as many as a ramp or a cycle has at least; start: the level before.
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
        """The time of the step."""
        return self.time if self.kind == RAMP else self.time * self.cycles

    @property
    def end(self) -> float:
        """The level at the end of the step."""
        return self.level if self.kind == RAMP else float(self.levels(np.array([self.cycles]))[0])

    def levels(self, cycles: np.ndarray) -> np.ndarray:
        """Return the levels after so many cycles (k,), which begin towards the peak from `start`."""
        phase = np.arcsin(self._share) if self.kind == SINE else np.pi / 2 * self._share
        sine = np.sin(2 * np.pi * cycles + phase)
        wave = sine if self.kind == SINE else 2 / np.pi * np.arcsin(np.clip(sine, -1, 1))
        return self.level * ((1 + self.R) / 2 + (1 - self.R) / 2 * wave)

    @property
    def _share(self) -> float:
        """Where the cycles begin: 1 at the peak, -1 at the valley."""
        share = (2 * self.start / self.level - (1 + self.R)) / (1 - self.R)
        return min(max(share, -1.0), 1.0)

    def pieces(self) -> list["LoadStep"]:
        """Return the step as a deck has it: ramps between the turning points of a triangle, met exactly."""
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
        """Return times and levels (k, 2), straight between, of a step of cycles.

        Of triangles the turning points and the ends, of sines as many points as there are increments.
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

    loads: the names of the load cases and of their sums, none where there is one load. Each step goes on
    where the one before ended. Raises CraftmeshError for other texts, for loads that are not there, and for
    cycles between whose peak and valley the load is not when they begin.
    """
    found: list[LoadStep] = []
    for text in texts:
        step = _step(text)
        if step.load not in (loads or [""]):
            known = f"one of {', '.join(loads)}, before a stroke" if loads else "no name: there is one load"
            raise CraftmeshError(f"steps: {text!r} is of load {step.load!r}; expected {known}")
        before = found[-1] if found else None
        if before is not None and (before.load == step.load or step.kind == RAMP):
            step = replace(step, start=before.end if before.load == step.load else 0.0)
        elif before is not None and abs(before.end) > ROUNDING:
            raise CraftmeshError(
                f"steps: {text!r} begins cycles of {step.load} while {before.load} is at {before.end:g}; "
                f"expected {step.load}/ramp:... before it, which goes from one to the other"
            )
        if step.kind != RAMP:
            low, high = sorted((step.level, step.level * step.R))
            room = ROUNDING * max(abs(low), abs(high))
            if not low - room <= step.start <= high + room:
                raise CraftmeshError(
                    f"steps: {text!r} goes between {low:g} and {high:g}, and the load is at {step.start:g} "
                    f"when it begins; expected a ramp to {step.level * step.R:g} before it"
                )
        found.append(step)
    return tuple(found)


def held_step(last: LoadStep) -> LoadStep:
    """Return a step that holds the load for a moment where the last one ended."""
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

"""What worker processes are asked to do, and what they answer when they cannot."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple


@dataclass(frozen=True)
class Limits:
    """What one task may use: `time` in seconds of the clock, `memory` in gigabytes of address space."""

    time: float
    memory: float


@dataclass(frozen=True)
class Job:
    """`function(shared, task)` for many tasks, each under the limits.

    The functions are a module's own; they and `shared` are pickled. `warm_up(shared)` is called once in
    each process before the first clock runs, so that time limits do not count compilation. shared_name:
    what `shared` is, for the error when it cannot be pickled.
    """

    function: Callable[[Any, Any], Any]
    shared: Any
    limits: Limits
    warm_up: Callable[[Any], None] | None = None
    shared_name: str = "what tasks share"


class Failure(NamedTuple):
    """Why a task has no result, and where: rows of what the task is about, if its error names them.

    `is_system`: the machine is at fault (a full disk, say), so that other attempts are in vain.
    """

    reason: str
    where: Any = ()
    is_system: bool = False

"""What of a campaign was not made, and the lines in its logs that say why."""

from pathlib import Path
from typing import NamedTuple

from craftmesh.report.case_files import Case

_ERROR = "craftmesh: error: "


class Failure(NamedTuple):
    """A case whose increments are not all there: a log that ends in an error, and that error."""

    case: str
    log: str
    line: str


def failures(case: Case, results: Path) -> list[Failure]:
    """Return the errors in which the logs of a case end, where it lacks increments that it was asked for.

    A job writes its log anew, so a stage that went well later has none. Without an error there is one
    entry, which says so: jobs that wait, run or were killed.
    """
    increments = case.increments
    growth = increments[-1].growth if increments else None
    has_ended = case.record["growth"] != "prescribed" and growth is not None and growth["ended"]
    if has_ended or len(increments) == case.record["increments"]:
        return []
    logs = results / "logs"
    found = [(path, _last_line(path)) for path in sorted((logs / case.name).rglob("*.log"))]
    told = [
        Failure(case.name, str(path.relative_to(logs)), line.removeprefix(_ERROR))
        for path, line in found
        if line.startswith(_ERROR)
    ]
    return told or [Failure(case.name, "", "not made yet, and no log ends in an error")]


def _last_line(path: Path) -> str:
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    return next((line for line in reversed(lines) if line.strip()), "")

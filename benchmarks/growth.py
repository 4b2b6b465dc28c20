"""Cracks that grow in a closed loop, each a campaign of its own, against what is known of their paths.

Ends with 1 where a case is farther off than it may be.
"""

import argparse
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

from grown.broken_through import broken_through, into_hole
from grown.campaigns import Check
from grown.closed import closed, half_closed, unopened
from grown.flat import ellipse, penny
from grown.inclined import inclined
from grown.plate import hole, straight
from grown.wings import wings
from measure import print_table, write_json

# a case grows its crack in campaigns within the folder that it gets
CASES: dict[str, Callable[[Path], list[Check]]] = {
    "penny": penny,
    "ellipse": ellipse,
    "inclined": inclined,
    "straight": straight,
    "hole": hole,
    "closed": closed,
    "closed with friction": partial(closed, friction=0.3),
    "wings": wings,
    "unopened": unopened,
    "half closed": half_closed,
    "broken through": broken_through,
    "into a hole": into_hole,
}
COLUMNS = {
    "case": "case",
    "what": "what",
    "found": "found",
    "known": "known",
    "within": "may be off by",
    "holds": "holds",
}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--case", action="append", choices=CASES, help="only this case; several may be given"
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures to this file")
    parser.add_argument("--folder", type=Path, help="keep the campaigns here, and go on where they stopped")
    arguments = parser.parse_args()
    rows: list[dict] = []
    with tempfile.TemporaryDirectory() as temporary:
        for name in arguments.case or CASES:
            checks = CASES[name]((arguments.folder or Path(temporary)) / name)
            rows += [{"case": name} | check._asdict() | {"holds": check.holds} for check in checks]
            write_json(arguments.json, {"growth": rows})
    print_table(rows, COLUMNS)
    return int(not all(row["holds"] for row in rows))


if __name__ == "__main__":
    sys.exit(main())

"""The note on TetGen's licence before a user's first mesh."""

import os
import sys
from contextlib import suppress
from pathlib import Path

NOTE = (
    "TetGen, under the AGPL-3.0, makes the tetrahedra unless tetrahedralize.mesher names another mesher; "
    "section Licence of README.md says what to observe before you distribute it or offer it as a service"
)


def licence_note() -> None:
    """Print NOTE once per user, on a terminal only, so that logs of jobs stay the same.

    An empty file in the user's cache folder marks that it was printed.
    """
    cache = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    printed = Path(cache, "craftmesh", "tetgen-licence-note")
    if sys.stderr.isatty() and not printed.exists():
        print(f"craftmesh: note: {NOTE}", file=sys.stderr, flush=True)
        with suppress(OSError):  # a read-only home folder: the note comes again
            printed.parent.mkdir(parents=True, exist_ok=True)
            printed.touch()

"""Remove surfaces and tetrahedra that no later stage needs, and files that killed jobs left.

Decks, meshes, results, pictures and logs of the cases stay, and the removal makes no job run again. If an
option changes and a stage needs a removed file, Snakemake makes the file first.
"""

import argparse
import shutil
from collections.abc import Iterator
from pathlib import Path

from craftmesh.atomic import UNFINISHED
from craftmesh.campaign.case_status import SPARE, case_statuses
from craftmesh.campaign.runs import LOCKS
from craftmesh.errors import CraftmeshError, existing


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("results", type=Path, help="folder of results")
    parser.add_argument("-n", "--dry-run", action="store_true", help="only print what would be removed")


def run(arguments: argparse.Namespace) -> None:
    if not arguments.dry_run and LOCKS.is_dir() and any(LOCKS.iterdir()):
        raise CraftmeshError(
            f"{LOCKS}: a campaign runs here; wait for its end, or after a kill run `snakemake --unlock`"
        )
    freed = 0
    for path in spare(existing(arguments.results)):
        size = disk(path)
        freed += size
        print(f"{path}: {size / 1e6:.1f} MB")
        if not arguments.dry_run:
            shutil.rmtree(path) if path.is_dir() else path.unlink()
    print(f"{freed / 1e6:.1f} MB {'can be freed' if arguments.dry_run else 'freed'}")


def spare(results: Path) -> Iterator[Path]:
    """Yield the files and folders in a folder of results that `clean` removes.

    Unfinished files of killed jobs are removed from all cases, files of stages only from finished cases.
    """
    yield from sorted(results.rglob(f"{UNFINISHED}*"))
    for one in case_statuses(results):
        if one.job is None:
            case = results / one.case
            yield from sorted(path for name in SPARE for path in case.glob(f"[0-9][0-9][0-9]/{name}"))


def disk(path: Path) -> int:
    """Return the size in bytes of a file, or of all files in a folder."""
    files = [path] if path.is_file() else [file for file in path.rglob("*") if file.is_file()]
    return sum(file.stat().st_size for file in files)

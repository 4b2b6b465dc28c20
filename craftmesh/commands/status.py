"""Print the status of the cases in a folder of results: a line each, and the disk space in use.

The subcommand reads only files and logs, so it may be called anywhere while a campaign runs.
"""

import argparse
from pathlib import Path

from craftmesh.campaign.case_status import case_statuses
from craftmesh.commands.clean import disk, spare
from craftmesh.errors import CraftmeshError, existing
from craftmesh.report.case_files import RECORD


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("results", type=Path, help="folder of results")


def run(arguments: argparse.Namespace) -> None:
    found = case_statuses(existing(arguments.results))
    if not found:
        raise CraftmeshError(f"{arguments.results}: no case with a {RECORD}; expected a folder of results")
    for one in sorted(found, key=lambda one: not one.failures):
        print(one)
    freed = sum(map(disk, spare(arguments.results)))
    print(f"{arguments.results}: {disk(arguments.results) / 1e6:.1f} MB", end="")
    print(f", {freed / 1e6:.1f} of them freed by `craftmesh clean {arguments.results}`" if freed else "")

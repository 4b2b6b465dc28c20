"""Code that all subcommands share: flags of files, and the printing of reports and warnings."""

import argparse
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from craftmesh.errors import CraftmeshError, existing
from craftmesh.io.json_file import write_json

SHORT = 12  # largest number of entries of a table or list that is printed
SENTENCES = ("changes", "notes")  # lists of a report of which every entry is printed


def add_output(parser: argparse.ArgumentParser, what: str) -> None:
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FILE", help=what)


def add_file(parser: argparse._ActionsContainer, flag: str, what: str) -> None:
    """Add a flag whose value is a file path; what: its help text."""
    parser.add_argument(flag, type=Path, metavar="FILE", help=what)


def add_config(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "config",
        type=Path,
        nargs="?",
        help="configuration .yaml (default: the configuration that snakemake would use)",
    )


def add_report(parser: argparse.ArgumentParser) -> None:
    add_file(parser, "--report", "write the stage's counts to this .json")


def add_units(parser: argparse.ArgumentParser, where: str) -> None:
    parser.add_argument(
        "--units",
        nargs=2,
        metavar=("LENGTH", "STRESS"),
        default=("", ""),
        help=f"names of your units, for example um MPa, for {where}; no value is converted",
    )


def tell(report: dict, path: Path | None) -> None:
    """Print a stage's report, one entry per line, and write the report to `path` if given."""
    for line in _lines(report):
        print(line)
    if path is not None:
        write_json(path, report)


def warn(*messages: str | None) -> None:
    """Print each message as one line on stderr; skip None and empty messages."""
    for message in filter(None, messages):
        print("craftmesh: warning:", " ".join(message.split()), file=sys.stderr, flush=True)


def _lines(report: dict, prefix: str = "") -> Iterator[str]:
    """Yield a line per entry of a report and per note; for a table or list over SHORT only its length."""
    for key, value in report.items():
        name = f"{prefix}{key}".replace("_", " ")
        if key in SENTENCES:
            yield from (f"{key.rstrip('s')}: {sentence}" for sentence in value)
        elif isinstance(value, dict) and len(value) <= SHORT:
            yield from _lines(value, f"{name}: ")
        elif isinstance(value, (dict, list, tuple)) and len(value) > SHORT:
            yield f"{name}: {len(value)} entries"
        elif isinstance(value, float):
            yield f"{name}: {value:.6g}"
        else:
            yield f"{name}: {value}"


def of_suffix(path: Path, table: Mapping[str, Any]) -> Any:
    """Return the value in `table`, by suffix, for a path's suffix.

    Raises CraftmeshError for an unknown suffix, and for a path that does not exist.
    """
    if existing(path).suffix not in table:
        raise CraftmeshError(
            f"{path}: suffix {path.suffix!r} is not a stage file's; expected {', '.join(table)}"
        )
    return table[path.suffix]

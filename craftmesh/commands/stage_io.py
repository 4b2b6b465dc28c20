"""What all verbs share: flags of files, and what a stage tells."""

import argparse
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from craftmesh.errors import CraftmeshError, existing
from craftmesh.io.json_file import write_json

SHORT = 12
SENTENCES = ("changes", "notes")  # lists of a report that are printed whole


def add_output(parser: argparse.ArgumentParser, what: str) -> None:
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FILE", help=what)


def add_file(parser: argparse._ActionsContainer, flag: str, what: str) -> None:
    """Add a flag that names a file."""
    parser.add_argument(flag, type=Path, metavar="FILE", help=what)


def add_config(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "config",
        type=Path,
        nargs="?",
        help="configuration .yaml; left out: the one that snakemake would take",
    )


def add_report(parser: argparse.ArgumentParser) -> None:
    add_file(parser, "--report", "write the stage's counts to this .json")


def add_units(parser: argparse.ArgumentParser, where: str) -> None:
    parser.add_argument(
        "--units",
        nargs=2,
        metavar=("LENGTH", "STRESS"),
        default=("", ""),
        help=f"names of your units, as um MPa, for {where}; nothing is converted",
    )


def tell(report: dict, path: Path | None) -> None:
    """Print a stage's report, one number or text a line, and write it to `path` if given."""
    for line in _lines(report):
        print(line)
    if path is not None:
        write_json(path, report)


def warn(*messages: str | None) -> None:
    """Print each warning as one line on stderr; nothing for None and empty ones."""
    for message in filter(None, messages):
        print("craftmesh: warning:", " ".join(message.split()), file=sys.stderr, flush=True)


def _lines(report: dict, prefix: str = "") -> Iterator[str]:
    """Yield the report's lines, one a note; other tables and lists of many entries are only counted."""
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
    """Return what a table has for the suffix of a stage file; raises CraftmeshError for others."""
    if existing(path).suffix not in table:
        raise CraftmeshError(
            f"{path}: suffix {path.suffix!r} is not a stage file's; expected {', '.join(table)}"
        )
    return table[path.suffix]

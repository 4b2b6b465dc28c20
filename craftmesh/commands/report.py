"""Put tables and histograms of all increments on one self-contained html page."""

import argparse
from pathlib import Path

from craftmesh.commands.stage_io import add_output, read_json
from craftmesh.report.page import write_report


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "quality", type=Path, nargs="+", metavar="QUALITY", help="files case/increment/quality.json"
    )
    add_output(parser, "page .html")


def run(arguments: argparse.Namespace) -> None:
    rows = [(path.parent.parent.name, path.parent.name, read_json(path)) for path in arguments.quality]
    write_report(arguments.output, rows)

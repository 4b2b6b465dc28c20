"""Write an HTML report on all campaigns in a folder of results: tables, pictures, a 3-D view."""

import argparse
from pathlib import Path

from craftmesh.atomic import atomic_path
from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.stage_io import add_file, add_output, warn
from craftmesh.errors import CraftmeshError, existing
from craftmesh.io.json_file import read_json
from craftmesh.report.case_files import RECORD, failures, read_cases, write_records
from craftmesh.report.page import page
from craftmesh.report.sweeps import ReportOptions


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("results", type=Path, help=f"folder of results, with cases that have a {RECORD}")
    add_file(
        parser,
        "--campaign",
        f"settings of a campaign, .json from the workflow: written to the {RECORD} of its cases",
    )
    add_options(parser, ReportOptions)
    add_output(parser, "report .html")


def run(arguments: argparse.Namespace) -> None:
    if arguments.campaign:
        write_records(existing(arguments.results), read_json(arguments.campaign), str(arguments.campaign))
    cases = read_cases(existing(arguments.results))
    if not cases:
        raise CraftmeshError(f"{arguments.results}: no case with a {RECORD}; run the workflow")
    failed = [failure for case in cases for failure in failures(case, arguments.results)]
    for failure in failed:
        warn(f"case {failure.case}, {failure.log or 'logs'}: {failure.line}")
    made = [case for case in cases if case.increments]
    text = page(made, options_from(arguments, ReportOptions), failed)
    with atomic_path(arguments.output) as temporary:
        temporary.write_text(text, encoding="utf-8")

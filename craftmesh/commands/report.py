"""Put the cases of all campaigns in a folder of results on one page: tables, pictures, a view to turn."""

import argparse
import json
from pathlib import Path

from craftmesh.atomic import atomic_path
from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.stage_io import add_output, existing, write_json
from craftmesh.errors import CraftmeshError
from craftmesh.report.case_files import RECORD, read_cases
from craftmesh.report.options import ReportOptions
from craftmesh.report.page import page
from craftmesh.report.versions import versions


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("results", type=Path, help=f"folder of results, with cases that have a {RECORD}")
    parser.add_argument(
        "--campaign",
        metavar="JSON",
        help=f"what a campaign asked for, as the workflow says it: goes to the {RECORD} of its cases first",
    )
    add_options(parser, ReportOptions)
    add_output(parser, "page .html")


def run(arguments: argparse.Namespace) -> None:
    if arguments.campaign:
        write_records(existing(arguments.results), arguments.campaign)
    cases = read_cases(existing(arguments.results))
    if not cases:
        raise CraftmeshError(
            f"{arguments.results}: no case with a {RECORD} and an increment; run the workflow"
        )
    text = page(cases, options_from(arguments, ReportOptions))
    with atomic_path(arguments.output) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_records(results: Path, campaign: str) -> None:
    """Write the record of each case of a campaign into its folder."""
    try:
        asked = json.loads(campaign)
    except ValueError as error:
        raise CraftmeshError(f"--campaign is not JSON ({error}); take what the workflow gives") from None
    for name, case in asked["cases"].items():
        config = asked["config"] | case.pop("settings")
        config["cracks"] = {crack: config["cracks"][crack] for crack in case["cracks"]}
        record = {"campaign": asked["campaign"], **case, "config": config, "versions": versions()}
        write_json(results / name / RECORD, record)

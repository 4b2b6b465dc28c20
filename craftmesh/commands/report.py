"""Put the cases of all campaigns in a folder of results on one page: tables, pictures, a view to turn."""

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from craftmesh.atomic import atomic_path
from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.stage_io import add_file, add_output, warn
from craftmesh.errors import CraftmeshError, existing
from craftmesh.io.json_file import read_json, write_json
from craftmesh.report.case_files import RECORD, failures, read_cases, versions
from craftmesh.report.page import page
from craftmesh.report.sweeps import ReportOptions


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("results", type=Path, help=f"folder of results, with cases that have a {RECORD}")
    add_file(
        parser,
        "--campaign",
        f"what a campaign asked for, .json from the workflow: for the {RECORD} of its cases",
    )
    add_options(parser, ReportOptions)
    add_output(parser, "page .html")


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


def write_records(results: Path, asked: Mapping[str, Any], campaign: str = "the campaign") -> None:
    """Write into the folder of each case what a campaign asked for: its sheet, and its configuration.

    Records of the campaign's cases that are no longer in its sheet are removed.
    """
    if not {"campaign", "config", "cases"} <= asked.keys():
        raise CraftmeshError(
            f"{campaign}: keys {', '.join(asked) or 'none'}; expected campaign, config and cases, as the"
            " workflow says them; leave --campaign out for cases that have been reported before"
        )
    for path in results.glob(f"*/{RECORD}"):  # of cases that the sheet no longer has
        if path.parent.name not in asked["cases"] and read_json(path).get("campaign") == asked["campaign"]:
            path.unlink()
    for name, case in asked["cases"].items():
        config = asked["config"] | case["settings"]
        config["cracks"] = {crack: config["cracks"][crack] for crack in case["cracks"]}
        told = {key: value for key, value in case.items() if key != "settings"}
        record = {"campaign": asked["campaign"], **told, "config": config, "versions": versions()}
        write_json(results / name / RECORD, record)

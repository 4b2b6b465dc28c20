"""The record of a campaign: its configuration and cases as the report keeps them, and cases to solve."""

import json
from typing import Any

from craftmesh.campaign.campaign import Campaign
from craftmesh.report.sweeps import SOLVED, sweeps

# Configuration keys that set where files are and how jobs run; they do not change results.
PLACES = ("cases", "results", "data", "chunks", "warm", "exports", "sweep", "node", "report")


def campaign_record(campaign: Campaign) -> str:
    """Return a campaign's configuration and cases as JSON text, for the report.

    The keys are campaign (path of the case table), config (without PLACES) and cases; a case has the
    sections in which its settings differ from config.
    """
    config = {key: value for key, value in campaign.config.items() if key not in PLACES}
    cases = _cases(campaign)
    for name, case in cases.items():
        settings = campaign.cases[name].settings
        case["settings"] = {key: settings[key] for key in config if settings[key] != config[key]}
    record = {"campaign": campaign.config["cases"], "config": config, "cases": cases}
    return json.dumps(record, separators=(",", ":"))


def solved_for_report(campaign: Campaign) -> set[str]:
    """Return the names of all cases in sweeps if `report.quantity` needs solutions, else an empty set.

    A sweep is a set of cases that differ in one value, which the report plots.
    """
    if campaign.config["report"]["quantity"] not in SOLVED:
        return set()
    asked = _cases(campaign)
    for name, case in asked.items():
        settings = campaign.cases[name].settings
        case["config"] = {key: value for key, value in settings.items() if key not in PLACES}
        case["config"]["cracks"] = {crack: settings["cracks"][crack] for crack in case["cracks"]}
    return {name for sweep in sweeps(asked) for name in sweep.cases}


def _cases(campaign: Campaign) -> dict[str, dict[str, Any]]:
    return {
        name: {
            "microstructure": case.microstructure,
            "cracks": list(case.cracks),
            "increments": case.increments,
            "growth": case.growth,
        }
        for name, case in campaign.cases.items()
    }

"""Turn craftmesher's config.xml into a configuration, and list settings without counterpart."""

import argparse
from pathlib import Path

from craftmesh.atomic import atomic_path
from craftmesh.campaign.config_schema import config_schema
from craftmesh.campaign.configuration import completed
from craftmesh.campaign.craftmesher import converted, read_config
from craftmesh.campaign.option_checks import checked_sizing
from craftmesh.commands.stage_io import add_output
from craftmesh.errors import CraftmeshError, existing

CASES = "config/cases.tsv"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("config", type=Path, help="craftmesher's config.xml")
    add_output(parser, "configuration .yaml, for `snakemake --configfile`")


def run(arguments: argparse.Namespace) -> None:
    import yaml

    try:
        sections, notes = converted(read_config(existing(arguments.config)), arguments.config.parent)
        config = {"cases": CASES} | sections
        checked_sizing(completed(config, config_schema())["sizing"])
    except CraftmeshError as error:
        place = "" if str(error).startswith(str(arguments.config)) else f"{arguments.config}: "
        raise CraftmeshError(f"{place}{error}") from None
    notes.append(f"cases: name the microstructures in {CASES}")
    comments = "".join(f"# {line}\n" for line in ["Not carried over, or to be checked:", *notes])
    text = yaml.safe_dump(config, sort_keys=False, allow_unicode=True)
    with atomic_path(arguments.output) as temporary:
        temporary.write_text(f"# From {arguments.config.name} of craftmesher.\n{comments}\n{text}", "utf-8")
    for note in notes:
        print(note)

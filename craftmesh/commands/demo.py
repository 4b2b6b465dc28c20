"""Run the demo of a crack that grows through a synthetic polycrystal; results go to this folder."""

import argparse

from craftmesh.campaign.workflow_location import DEFAULT, home, read_config
from craftmesh.commands.compile import compiling_ahead
from craftmesh.commands.run import add_cores, run_snakemake


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_cores(parser)


def run(arguments: argparse.Namespace) -> int:
    config = home() / DEFAULT
    cases = home() / read_config(config)["cases"]
    words = ["--cores", arguments.cores, "--configfile", str(config), "--config", f"cases={cases}"]
    with compiling_ahead():
        return run_snakemake(words)

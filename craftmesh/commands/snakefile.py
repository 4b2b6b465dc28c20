"""Print where the Snakemake workflow is installed, for `snakemake -s` and for `module`."""

import argparse

from craftmesh.campaign.workflow_location import snakefile


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add nothing: the subcommand has no options."""


def run(_: argparse.Namespace) -> None:
    """Print the path of workflow/Snakefile."""
    print(snakefile())

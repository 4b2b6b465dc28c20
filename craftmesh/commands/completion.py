"""Print a shell script that completes subcommands, options and files; shtab makes the script."""

import argparse
import importlib
from pathlib import Path

from craftmesh.commands.flags import Parser
from craftmesh.commands.verbs import COMMANDS, VERBS, module_name, summary
from craftmesh.extras import extra

with extra("workflow"):
    import shtab

SHELLS = ("bash", "zsh", "tcsh")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("shell", choices=SHELLS, help="shell that will run the script")


def run(arguments: argparse.Namespace) -> None:
    print(shtab.complete(whole_parser(), arguments.shell))


def whole_parser() -> argparse.ArgumentParser:
    """Return a parser of all subcommands, with file completion for arguments that are paths."""
    parser = Parser(prog="craftmesh")
    parser.add_argument("--version", action="store_true", help="print the version")
    verbs = parser.add_subparsers(parser_class=Parser)
    for verb in VERBS:
        own = verbs.add_parser(verb, help=summary(verb))
        importlib.import_module(f"{COMMANDS}.{module_name(verb)}").add_arguments(own)
        for action in own._actions:
            if action.type is Path:
                action.complete = shtab.FILE  # type: ignore[attr-defined]
    return parser

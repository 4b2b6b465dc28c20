"""Print a shell's script that completes verbs, their options and files, made by shtab."""

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
    parser.add_argument("shell", choices=SHELLS, help="the shell that is to run the script")


def run(arguments: argparse.Namespace) -> None:
    print(shtab.complete(whole_parser(), arguments.shell))


def whole_parser() -> argparse.ArgumentParser:
    """Return a parser with every verb of the command line; files are completed where a path is expected."""
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

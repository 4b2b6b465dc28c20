"""Every command that the documentation shows is one that the programs take: its verb, flags and values."""

import argparse
import importlib
import re

import pytest
from shown_commands import PAGES, ROOT, commands_of

from craftmesh.commands.flags import Parser
from craftmesh.commands.verbs import COMMANDS, VERBS, module_name
from craftmesh.errors import CraftmeshError

PLACEHOLDER = re.compile(r"\.\.\.|…|^[A-Z]{4,}$|\$\(")


def parser_of(verb: str) -> argparse.ArgumentParser:
    parser = Parser(prog=f"craftmesh {verb}")
    importlib.import_module(f"{COMMANDS}.{module_name(verb)}").add_arguments(parser)
    return parser


def fault_of_craftmesh(words: list[str], whole: bool) -> str:
    verb, *rest = words[1:]
    if verb in ("--help", "--version", "SUBCOMMAND"):
        return ""
    if verb not in VERBS:
        return f"{verb} is no verb"
    parser = parser_of(verb)
    known = {flag for action in parser._actions for flag in action.option_strings}
    unknown = [word for word in rest if word.startswith("--") and word.split("=")[0] not in known]
    if unknown:
        return f"{verb} has no {unknown[0]}"
    if not whole or any(map(PLACEHOLDER.search, rest)):
        return ""
    try:
        parser.parse_args(rest)
    except CraftmeshError as error:
        return str(error)
    return ""


def fault_of_snakemake(words: list[str], whole: bool) -> str:
    from snakemake.cli import get_argument_parser

    parser = get_argument_parser()
    known = {flag for action in parser._actions for flag in action.option_strings}
    flags = [word.split("=")[0] for word in words[1:] if re.match(r"--?[a-zA-Z]", word)]
    unknown = [flag for flag in flags if flag not in known]
    if unknown:
        return f"snakemake has no {unknown[0]}"
    files = [after for flag, after in zip(words, words[1:]) if flag == "--configfile"]
    gone = [name for name in files if name.startswith("examples/") and not (ROOT / name).is_file()]
    return f"{gone[0]} is not there" if gone else ""


def fault_of_make(words: list[str], whole: bool) -> str:
    targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), flags=re.M)
    gone = [word for word in words[1:] if word not in targets and not re.search("[=-]", word[:1])]
    return f"make has no target {gone[0]}" if gone else ""


def fault_of_python(words: list[str], whole: bool) -> str:
    name = next((word for word in words[1:] if word.endswith(".py")), "")
    if not name or not name.startswith("benchmarks/"):
        return ""
    if not (ROOT / name).is_file():
        return f"{name} is not there"
    sources = "".join(path.read_text() for path in ROOT.glob("benchmarks/*.py"))
    unknown = [word for word in words if word.startswith("--") and f'"{word}"' not in sources]
    return f"{name} has no {unknown[0]}" if unknown else ""


FAULTS = {
    "craftmesh": fault_of_craftmesh,
    "snakemake": fault_of_snakemake,
    "make": fault_of_make,
    "python": fault_of_python,
}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_commands_of_a_page_are_accepted(page):
    faults = []
    for shown in commands_of(page.read_text()):
        fault = shown.words[0] in FAULTS and FAULTS[shown.words[0]](shown.words, shown.is_whole)
        if fault:
            faults.append(f"{shown.line}: {fault}")
    assert not faults


def test_the_pages_show_commands():
    shown = [shown.words for page in PAGES for shown in commands_of(page.read_text())]
    assert {words[1] for words in shown if words[0] == "craftmesh"} >= set(VERBS)


@pytest.mark.parametrize(
    "line, fault",
    [
        ("craftmesh gradat a.vtp -o b.vtp", "gradat is no verb"),
        ("craftmesh gradate a.vtp --split 2 -o b.vtp", "gradate has no --split"),
        ("craftmesh gradate a.vtp --split-ratio x -o b.vtp", "invalid float"),
        ("snakemake --coers 2", "snakemake has no --coers"),
        ("snakemake --configfile examples/gone/config.yaml", "gone/config.yaml is not there"),
        ("make tests", "no target tests"),
        ("python benchmarks/gone.py", "benchmarks/gone.py is not there"),
    ],
)
def test_faults_are_found(line, fault):
    (shown,) = commands_of(f"```\n{line}\n```")
    assert fault in FAULTS[shown.words[0]](shown.words, shown.is_whole)

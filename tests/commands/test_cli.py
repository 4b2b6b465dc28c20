"""The command line: verbs in the order of the way, one line and status 1 for every error, quick start."""

import importlib
import subprocess
import sys
from pathlib import Path

import pytest

from craftmesh import cli
from craftmesh.campaign.config_schema import SECTIONS, config_schema
from craftmesh.commands.flags import Parser
from craftmesh.errors import CraftmeshError


def module_of(verb: str):
    return importlib.import_module(
        "craftmesh.commands." + {"import": "import_"}.get(verb, verb.replace("-", "_"))
    )


def said(capsys) -> str:
    """Return the one line on stderr; nothing else was printed."""
    out, err = capsys.readouterr()
    assert out == "" and err.endswith("\n") and err.count("\n") == 1
    return err


def test_help_lists_the_stages_in_the_order_of_the_way(capsys):
    assert cli.main(["--help"]) == 0
    text = capsys.readouterr().out
    way = [
        "import",
        "remesh",
        "crack",
        "stitch",
        "gradate",
        "tetrahedralize",
        "assemble",
        "inp",
        "check",
        "report",
    ]
    places = [text.index(f"\n  {verb} ") for verb in way]
    assert places == sorted(places)


def test_verbs_are_the_modules_of_the_folder():
    folder = Path(cli.__file__).with_name("commands")
    modules = {path.stem for path in folder.glob("*.py") if "\ndef add_arguments(" in path.read_text()}
    assert sorted(map(cli.module_name, cli.VERBS)) == sorted(modules)


@pytest.mark.parametrize("verb", cli.VERBS)
def test_what_a_verb_does_is_the_start_of_its_docstring(verb):
    text = cli.summary(verb)
    assert 20 < len(text) <= 90
    assert module_of(verb).__doc__.lower().startswith(text.lower())


def known_to(verb):
    """Return the names of what a verb takes."""
    parser = Parser(prog=verb)
    module_of(verb).add_arguments(parser)
    return {action.dest for action in parser._actions}


@pytest.mark.parametrize("section", sorted(set(SECTIONS) - {"node", "units"}))  # of the workflow, no verb's
def test_verb_of_a_section_takes_its_keys(section):
    verb = {"sizing": "size"}.get(section, section)
    # the section of the growth is shared: fracture finds where a front goes, grow moves it
    known = known_to("fracture") ^ known_to("grow") if verb == "grow" else known_to(verb)
    assert set(config_schema()["properties"][section]["properties"]) <= known


def test_solve_takes_the_model_that_inp_takes():
    assert set(config_schema()["properties"]["inp"]["properties"]) - {"includes", "style"} <= known_to(
        "solve"
    )


def test_help_does_not_load_the_stages():
    code = "import sys; from craftmesh import cli; cli.main(['--help']); print('numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "False"


@pytest.mark.parametrize("verb", cli.VERBS)
def test_every_verb_has_help(verb, capsys):
    with pytest.raises(SystemExit) as exit:
        cli.main([verb, "--help"])
    assert exit.value.code == 0
    text = capsys.readouterr().out
    assert (
        text.startswith(f"usage: craftmesh {verb}") and module_of(verb).__doc__.split(".")[0][:30] in text
    )


@pytest.mark.parametrize(
    ("words", "line"),
    [
        ("other", "unknown subcommand 'other'; known: init, plan, run"),
        ("tetrahedralise", "unknown subcommand 'tetrahedralise'; did you mean tetrahedralize?"),
        ("remesh", "the following arguments are required"),
        ("remesh gone.npz -o s.vtp", "gone.npz: no such file"),
        ("gradate gone.vtp -o s.vtp", "gone.vtp"),
        ("import gone.npz --labels l.npz", "gone.npz: no such file"),
        ("import gone.npz", "nothing to write"),
        ("tetrahedralize s.vtp --chunk 3/2 -o c.npz", "'3/2' is not K/N"),
        ("check gone.vtu", "gone.vtu: no such file"),
        ("inp gone.vtu -o model.inp", "gone.vtu"),
        ("stitch gone -o s.vtp", "gone: no such file"),
        ("report gone.json -o r.html", "gone.json: no such file"),
    ],
)
def test_mistakes_are_one_line(words, line, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert cli.main(words.split()) == 1
    text = said(capsys)
    assert text.startswith("craftmesh: error: ") and line in text
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("error", "status", "line"),
    [
        (CraftmeshError("grain 7:\n open"), 1, "craftmesh: error: grain 7: open\n"),
        (MemoryError(), 1, "craftmesh: error: out of memory"),
        (KeyboardInterrupt(), 130, "craftmesh: error: interrupted"),
        (
            PermissionError(13, "Permission denied", "a.vtp"),
            1,
            "craftmesh: error: a.vtp: Permission denied\n",
        ),
    ],
)
def test_every_kind_of_failure_is_one_line(error, status, line, capsys, monkeypatch):
    def fail(argv):
        raise error

    monkeypatch.setattr(cli, "run", fail)
    assert cli.main([]) == status
    assert said(capsys).startswith(line)


def test_check_refuses_other_files(tmp_path, capsys):
    (tmp_path / "a.txt").touch()
    assert cli.main(["check", str(tmp_path / "a.txt")]) == 1
    assert "suffix '.txt'" in said(capsys)

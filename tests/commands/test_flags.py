"""Flags made from option classes give back what was asked, and say units and defaults."""

from dataclasses import MISSING, dataclass
from typing import Literal

import pytest

from craftmesh.campaign.campaign import command_flags
from craftmesh.commands.flags import Parser, add_options, options_from
from craftmesh.errors import CraftmeshError
from craftmesh.options import option


@dataclass(frozen=True)
class WarpOptions:
    l_min: float = option(0.5, "edge length", "um")
    rounds: int | None = option(None, "rounds at most")
    fill: bool = option(True, "fill gaps")
    scheme: Literal["fast", "safe"] = option("fast", "scheme")
    centre: tuple[float, float, float] = option((0.0, 0.0, 0.0), "centre", "um")
    plain: tuple[float, float] = option((1.0, 2.0), "two numbers")
    steps: tuple[float | str | tuple[float, float], ...] | None = option(None, "any words")


@dataclass(frozen=True)
class NeededOptions:
    path: str = option(MISSING, "a path")


def parsed(words: str, *classes: type):
    parser = Parser(prog="craftmesh warp")
    add_options(parser, *classes)
    arguments = parser.parse_args(words.split())
    return options_from(arguments, classes[0])


def test_no_flag_leaves_the_defaults():
    assert parsed("", WarpOptions) == WarpOptions()


def test_every_kind_of_value_is_read():
    words = "--l-min 1e-3 --rounds 4 --no-fill --scheme safe --centre -1 -2e-3 3"
    words += " --plain 4 5 --steps 2 3,4 a.stl"
    wanted = WarpOptions(1e-3, 4, False, "safe", (-1.0, -2e-3, 3.0), (4.0, 5.0), (2.0, (3.0, 4.0), "a.stl"))
    assert parsed(words, WarpOptions) == wanted


def test_flags_of_a_configuration_come_back_as_its_values():
    section = {
        "l_min": 2e-5,
        "rounds": None,
        "fill": False,
        "centre": [-1, 0, 1e-7],
        "steps": [[1, 2], "x.stl"],
    }
    wanted = WarpOptions(2e-5, None, False, centre=(-1.0, 0.0, 1e-7), steps=((1.0, 2.0), "x.stl"))
    assert parsed(command_flags(section), WarpOptions) == wanted


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--l-min x", "invalid float value: 'x'"),
        ("--scheme slow", "choose from"),
        ("--centre 1 2", "expected 3 arguments"),
        ("--l-mi 3", "unrecognized arguments: --l-mi"),
    ],
)
def test_bad_flags_are_refused_in_one_line(words, said):
    with pytest.raises(CraftmeshError, match=said) as caught:
        parsed(words, WarpOptions)
    assert "\n" not in str(caught.value) and "craftmesh warp --help" in str(caught.value)


def test_value_without_default_has_to_be_given():
    with pytest.raises(CraftmeshError, match="--path"):
        parsed("", NeededOptions)
    assert parsed("--path here", NeededOptions).path == "here"


def test_help_names_units_defaults_and_groups():
    parser = Parser(prog="craftmesh warp")
    add_options(parser, WarpOptions)
    text = " ".join(parser.format_help().split())
    assert "warp options" in text
    assert "edge length (in um; default 0.5)" in text
    assert "rounds at most --" in text, "a default of None is not shown"

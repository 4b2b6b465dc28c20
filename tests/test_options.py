"""Every option class: what is out of bounds is refused in library, command line and schema alike."""

import dataclasses
import importlib
import math
import shlex
from pathlib import Path
from typing import Literal, get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from craftmesh.campaign.campaign import command_flags
from craftmesh.campaign.config_schema import CRACK, SECTIONS, config_schema, option_class
from craftmesh.campaign.configuration import completed
from craftmesh.commands.flags import Parser, add_options, options_from
from craftmesh.cracks.options import BY_FILES, BY_NUMBERS, OF_GRAINS, Shape
from craftmesh.errors import CraftmeshError
from craftmesh.io.file_volume import DEGREES, RADIANS
from craftmesh.io.volume_format import AUTO, SUFFIXES
from craftmesh.mechanics.user_materials import UserMaterial
from craftmesh.options import BOUNDS, Options, alternatives, choices_of, hints_of, items_of
from craftmesh.report.sweeps import QUANTITIES, Quantity
from craftmesh.types import GRAIN, UNINDEXED, VOID
from craftmesh.voxels.reading import Format, ReadOptions

UNITS = {"", "model units", "l_min", "degrees", "voxels", "s", "GB", "MB"}
PATHS = [*(path for _, classes in SECTIONS.values() for path in classes), CRACK]
CLASSES = {path: option_class(path) for path in PATHS}
SCHEMA = config_schema()


def section_of(path: str) -> dict:
    """Return the schema of one class's section."""
    if path == CRACK:
        return SCHEMA["properties"]["cracks"]["additionalProperties"]
    name = next(name for name, (_, classes) in SECTIONS.items() if path in classes)
    return SCHEMA["properties"][name]


def number_of(hint) -> type | None:
    """Return int or float where a field is a number or a tuple of numbers."""
    parts = [part for part in alternatives(hint) if part is not type(None)]
    kind = items_of(parts[0])[0] if items_of(parts[0]) else parts[0]
    return kind if kind in (int, float) else None


def value_with(cls: type, field: dataclasses.Field, number):
    """Return a value of the field that is sound but for the number."""
    items = items_of(alternatives(hints_of(cls)[field.name])[0])
    if items is None:
        return number
    default = field.default or (number,) * (items[1] or 1)
    return (*default[:-1], number)


def beyond(bound: str, limit: float, kind: type):
    """Return a number just beyond a bound."""
    step = (1 if kind is int else 1e-3) * (1 if bound in ("below", "at_most") else -1)
    on_the_limit_is_beyond = bound in ("above", "below")
    return kind(limit if on_the_limit_is_beyond else limit + step)


def wrong_numbers():
    for path, cls in CLASSES.items():
        for field in dataclasses.fields(cls):
            kind = number_of(hints_of(cls)[field.name])
            if kind is None:
                continue
            bad = [beyond(name, limit, kind) for name, limit in field.metadata["bounds"].items()]
            bad += [math.nan, math.inf, -math.inf] if kind is float else [1.5]
            for number in bad:
                yield pytest.param(
                    path, field.name, value_with(cls, field, number), id=f"{field.name}={number}"
                )


def all_refuse(path: str, name: str, value) -> None:
    """The library, the command line and the schema refuse the value in one line that names the key."""
    cls = CLASSES[path]
    with pytest.raises(CraftmeshError, match=f"^{name} is .*; expected ") as in_library:
        cls(**{name: value})
    parser = Parser(prog="craftmesh verb")
    add_options(parser, cls)
    words = command_flags({name: list(value) if isinstance(value, tuple) else value}).split()
    with pytest.raises(CraftmeshError) as on_command_line:
        options_from(parser.parse_args(words), cls)
    assert name in str(on_command_line.value).replace("-", "_")
    in_config = {name: list(value) if isinstance(value, tuple) else value}
    with pytest.raises(CraftmeshError, match=rf"^{name}(\.\d+)? is .*; expected ") as in_schema:
        completed(in_config, section_of(path))
    for caught in (in_library, on_command_line, in_schema):
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("path", "name", "value"), list(wrong_numbers()))
def test_numbers_out_of_bounds_are_refused_everywhere(path, name, value):
    all_refuse(path, name, value)


def wrong_types():
    for path, cls in CLASSES.items():
        for field in dataclasses.fields(cls):
            hint = hints_of(cls)[field.name]
            yield path, field.name, {"a": 1}
            if number_of(hint) or bool in alternatives(hint):
                yield path, field.name, "three"
            if choices_of(hint):
                yield path, field.name, "no such choice"
            if bool in alternatives(hint):
                yield path, field.name, 1
            elif items_of(alternatives(hint)[0]) is None:
                yield path, field.name, True


@pytest.mark.parametrize(("path", "name", "value"), list(wrong_types()))
def test_wrong_types_are_refused_by_library_and_schema(path, name, value):
    with pytest.raises(CraftmeshError, match=f"^{name} is .*; expected "):
        CLASSES[path](**{name: value})
    with pytest.raises(CraftmeshError, match=f"^{name} is .*; expected "):
        completed({name: value}, section_of(path))


@pytest.mark.parametrize("path", PATHS)
def test_defaults_are_admitted_everywhere(path):
    cls = CLASSES[path]
    defaults = dataclasses.asdict(cls())
    filled = completed({}, section_of(path))
    assert {
        k: tuple(v) if isinstance(v, list) else v for k, v in filled.items() if k in defaults
    } == defaults
    parser = Parser(prog="craftmesh verb")
    add_options(parser, cls)
    words = command_flags({name: filled[name] for name in defaults})
    assert options_from(parser.parse_args(shlex.split(words)), cls) == cls()


@pytest.mark.parametrize("path", PATHS)
def test_schema_has_the_bounds_and_units_of_the_class(path):
    for field in dataclasses.fields(CLASSES[path]):
        made = section_of(path)["properties"][field.name]
        made = made.get("items", {}) | made
        for name, limit in field.metadata["bounds"].items():
            assert made[BOUNDS[name].schema_key] == limit
        assert field.metadata["unit"] in UNITS


def test_every_option_class_is_a_part_of_the_configuration():
    root = Path(importlib.import_module("craftmesh").__file__).parent
    found = set()
    for file in root.rglob("*.py"):
        if "Options):" in file.read_text():
            name = ".".join(file.relative_to(root.parent).with_suffix("").parts)
            module = importlib.import_module(name)
            found |= {one for one in vars(module).values() if is_own_option_class(one, name)}
    assert found - {UserMaterial} == set(CLASSES.values())  # UserMaterial: a template's keys


def is_own_option_class(one, module: str) -> bool:
    is_class = isinstance(one, type) and issubclass(one, Options) and one is not Options
    return is_class and one.__module__ == module


@given(st.floats(allow_nan=True), st.sampled_from(["l_min", "r0"]))
def test_a_number_is_refused_if_and_only_if_it_breaks_the_bound(number, name):
    cls = CLASSES["sizing.sizing.SizingOptions"]
    is_sound = math.isfinite(number) and (number > 0 or (number == 0 and name == "r0"))
    if is_sound:
        assert getattr(cls(**{name: number}), name) == number
    else:
        with pytest.raises(CraftmeshError, match=f"^{name} is"):
            cls(**{name: number})


@pytest.mark.parametrize(
    ("path", "values", "said"),
    [
        ("sizing.sizing.SizingOptions", {"l_min": 2.0, "l_max": 1.0}, "l_min is 2; expected at most l_max"),
        ("sizing.sizing.SizingOptions", {"r0": 2.0, "r1": 1.0}, "r1 is 1; expected at least r0"),
        (
            "voxels.options.GenerateOptions",
            {"shape": (2, 2, 2), "grains": 9},
            "grains is 9; expected at most",
        ),
        ("gradation.gradate.GradateOptions", {"collapse_ratio": 1.0}, "a number >= 0 and < 1"),
        (
            "remeshing.remesh.RemeshOptions",
            {"laplace_laps": -3},
            "laplace_laps is -3; expected a whole num",
        ),
        ("insertion.options.InsertOptions", {"max_turn": -5.0}, "and <= 180, in degrees"),
        (CRACK, {"semi_axes": (1.0,)}, "a list of 2 numbers > 0, in model units"),
    ],
)
def test_what_is_expected_is_said(path, values, said):
    with pytest.raises(CraftmeshError, match=said):
        CLASSES[path](**values)


def test_choices_in_types_are_those_that_the_code_knows():
    assert get_args(Shape) == (*BY_NUMBERS, *BY_FILES, *OF_GRAINS)
    assert get_args(Format) == (AUTO, *SUFFIXES)
    assert get_args(Quantity) == tuple(QUANTITIES)
    assert choices_of(hints_of(ReadOptions)["background"]) == (AUTO, UNINDEXED, VOID, GRAIN)
    assert choices_of(hints_of(ReadOptions)["angles"]) == (AUTO, DEGREES, RADIANS)
    assert choices_of(Literal["a"] | None) == ("a",) and choices_of(str | None) == ()
    assert alternatives(Literal["a"] | None) == (str, type(None))

"""Checks that the names in an input deck are defined, in the part or model where solvers look for them."""

import re
from collections.abc import Iterator, Sequence

from craftmesh.deck.includes import Block
from craftmesh.deck.limits import ROW_LIMIT
from craftmesh.deck.parts import NAMING, OUTPUT

_OF_SECTION = ("ELSET", "MATERIAL", "ORIENTATION", "CONTROLS")  # parameters of sections that refer to names
# Keywords that define a set or a surface, with the parameter that holds its name.
_DEFINING = {"NODE": "NSET", "ELEMENT": "ELSET", "NSET": "NSET", "ELSET": "ELSET", "SURFACE": "NAME"}
_IN_PARTS = ("ELEMENT", "SOLID SECTION", "COHESIVE SECTION")
_OF_MODEL = ("MATERIAL", "SURFACE INTERACTION", "CONTACT PAIR", "AMPLITUDE", "STEP")


def reference_faults(blocks: Sequence[Block]) -> list[str]:
    """Return one sentence for each undefined name and each keyword in a wrong place.

    Sets, materials, orientations and controls of sections must be in the deck. Names of sets and surfaces
    in sets, surfaces, loads, contact and output must be defined on earlier lines. If they are defined in a
    part, an instance must stand before the name. Cohesive elements must have sections if the deck has any.
    """
    return [*_section_faults(blocks), *_unnamed_layers(blocks), *_set_faults(blocks), *_part_faults(blocks)]


def _section_faults(blocks: Sequence[Block]) -> list[str]:
    """Return a sentence for each name of a section that is not defined in the deck."""
    defined: dict[str, set[str]] = {kind: set() for kind in _OF_SECTION}
    for block in blocks:
        if block.keyword in ("ELEMENT", "ELSET"):
            defined["ELSET"].add(block.parameters.get("ELSET", ""))
        elif block.keyword in ("MATERIAL", "ORIENTATION", "SECTION CONTROLS"):
            defined[block.keyword.split()[-1]].add(block.parameters.get("NAME", ""))
    return [
        f"{block.place}: the section names {kind} {block.parameters[kind]}, which is not in the deck"
        for block in blocks
        if block.keyword in ("SOLID SECTION", "COHESIVE SECTION")
        for kind in _OF_SECTION
        if kind in block.parameters and block.parameters[kind] not in defined[kind]
    ]


def _unnamed_layers(blocks: Sequence[Block]) -> list[str]:
    """Return sentences on cohesive elements that have no section, if the deck has sections."""
    sections = [block for block in blocks if block.keyword.endswith(" SECTION")]
    named = {block.parameters.get("ELSET", "") for block in sections if block.keyword == "COHESIVE SECTION"}
    sets = [
        block for block in blocks if block.keyword == "ELSET" and block.parameters.get("ELSET") in named
    ]
    named |= {word for block in sets for word in _words(block, ROW_LIMIT)}
    return [
        f"{block.place}: no cohesive section covers elements of {block.parameters.get('ELSET', 'no set')}"
        for block in blocks
        if sections and block.keyword == "ELEMENT"
        if block.parameters.get("TYPE", "").startswith("COH")
        if block.parameters.get("ELSET", "") not in named
    ]


def _set_faults(blocks: Sequence[Block]) -> Iterator[str]:
    """Yield sentences on names of sets and surfaces that no earlier line defines in the part or model."""
    instances = {block.parameters.get("NAME", "") for block in blocks if block.keyword == "INSTANCE"}
    known: dict[bool, set[str]] = {False: set(), True: set()}  # True: in a part; False: in the model
    inside = False
    for block in blocks:
        inside = block.keyword == "PART" or (inside and block.keyword != "END PART")
        for name in _named(block):
            instance, _, own = name.rpartition(".")
            if own in known[inside or bool(instance)] and (not instance or instance in instances):
                continue
            in_part = own in known[True] and instances
            hint = f"; expected {min(instances)}.{own}, of the instance" if in_part else ""
            yield f"{block.place}: no set or surface {name} is defined before{hint}"
        known[inside].add(block.parameters.get(_DEFINING.get(block.keyword, ""), ""))


def _named(block: Block) -> list[str]:
    """Return the names of sets and surfaces that a block refers to, without names that it defines."""
    if block.keyword.endswith(OUTPUT):
        return [block.parameters[key] for key in ("NSET", "ELSET") if key in block.parameters]
    count = NAMING.get(block.keyword, 0)
    if block.keyword in ("NSET", "ELSET"):
        count = ROW_LIMIT
    elif block.keyword == "SURFACE" and block.parameters.get("TYPE", "ELEMENT") == "ELEMENT":
        count = 1
    return _words(block, count)


def _words(block: Block, count: int) -> list[str]:
    """Return the words among the first `count` entries of each data line, in capitals, without numbers."""
    if not count or not re.search("[A-Za-z]", block.data):
        return []
    words = (word.strip() for row in block.data.upper().splitlines() for word in row.split(",")[:count])
    return [word for word in dict.fromkeys(words) if word and not word.rpartition(".")[2].isdecimal()]


def _part_faults(blocks: Sequence[Block]) -> Iterator[str]:
    """Yield sentences on keywords that break the order of a deck in parts.

    Parts come first, then their instances, then materials and steps.
    """
    parts = {block.parameters.get("NAME", "") for block in blocks if block.keyword == "PART"}
    inside = False
    for block in blocks:
        if block.keyword in ("PART", "END PART") and inside == (block.keyword == "PART"):
            yield f"{block.place}: *{block.keyword}, {'within' if inside else 'with no start of'} a part"
        inside = block.keyword == "PART" or (inside and block.keyword != "END PART")
        if parts and block.keyword in _IN_PARTS and not inside:
            yield f"{block.place}: *{block.keyword} is outside the parts, but Abaqus looks for it within"
        if inside and block.keyword in _OF_MODEL:
            yield f"{block.place}: *{block.keyword} is within a part; expected it after the assembly"
        if block.keyword == "INSTANCE" and block.parameters.get("PART", "") not in parts:
            yield f"{block.place}: the part {block.parameters.get('PART')} of the instance is not defined"
    if inside:
        yield "the last part has no *END PART"

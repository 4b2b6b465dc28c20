"""A deck laid out as Abaqus/CAE does: the body is a part, which has one instance in the assembly."""

import re
from collections.abc import Iterable, Iterator
from itertools import chain

PART, INSTANCE = "BODY", "BODY-1"
HEAD = f"*PART, NAME={PART}\n"
_ASSEMBLY = f"""\
*END PART
*ASSEMBLY, NAME=ASSEMBLY
*INSTANCE, NAME={INSTANCE}, PART={PART}
*END INSTANCE
*END ASSEMBLY
"""
# What belongs to a part of what follows its mesh; all else, materials and steps among it, is the model's.
OF_PART = {"NODE", "NSET", "ELEMENT", "ELSET", "SURFACE", "RIGID BODY", "DISTRIBUTION", "ORIENTATION"}
OF_PART |= {"SOLID SECTION", "COHESIVE SECTION"}
# Keywords whose data lines begin with so many names or numbers of nodes, sets and surfaces.
NAMING = {"BOUNDARY": 1, "CLOAD": 1, "DSLOAD": 1, "TEMPERATURE": 1, "INITIAL CONDITIONS": 1}
NAMING |= {"CONTACT PAIR": 2}
OUTPUT = ("PRINT", "FILE", "OUTPUT")  # endings of keywords whose parameters name sets, of an instance


def in_parts(lines: Iterable[str]) -> Iterator[str]:
    """Yield the lines that follow a mesh in a flat deck, those of the part before the others.

    The mesh stands before them, after HEAD. Names of sets and surfaces, and numbers of nodes, carry the
    instance after the assembly.
    """
    of_model: list[str] = []
    keyword = ""
    for line in chain.from_iterable(piece.splitlines(keepends=True) for piece in lines):
        is_head = line.startswith("*") and not line.startswith("**")
        if is_head:
            keyword = line[1:].partition(",")[0].strip().upper()
        if keyword in OF_PART:
            yield line
        elif is_head:
            of_model.append(re.sub(r"\b(NSET|ELSET)\s*=\s*", rf"\1={INSTANCE}.", line, flags=re.I))
        else:
            count = 0 if line.startswith("**") else NAMING.get(keyword, 0)
            of_model.append(re.sub(r"[^,\s]+", rf"{INSTANCE}.\g<0>", line, count=count) if count else line)
    yield _ASSEMBLY
    yield from of_model

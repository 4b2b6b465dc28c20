"""A deck in the layout of Abaqus/CAE: the body is a part, with one instance in the assembly."""

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
# Keywords after the mesh that belong to the part; all others, such as materials and steps, are the model's.
OF_PART = {"NODE", "NSET", "ELEMENT", "ELSET", "SURFACE", "RIGID BODY", "DISTRIBUTION", "ORIENTATION"}
OF_PART |= {"SOLID SECTION", "COHESIVE SECTION"}
# Number of entries with which the data lines of a keyword begin that are names of sets or surfaces, or
# numbers of nodes.
NAMING = {"BOUNDARY": 1, "CLOAD": 1, "DSLOAD": 1, "TEMPERATURE": 1, "INITIAL CONDITIONS": 1}
NAMING |= {"CONTACT PAIR": 2}
OUTPUT = ("PRINT", "FILE", "OUTPUT")  # endings of keywords whose parameters name sets of the instance


def in_parts(lines: Iterable[str]) -> Iterator[str]:
    """Yield the lines after the mesh of a flat deck in the order part, assembly, model.

    HEAD and the mesh stand before these lines. After the assembly, names of sets and surfaces and numbers
    of nodes get the instance as a prefix, such as BODY-1.XMIN.
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

"""A small reader of input decks for tests; it shares no code with the writer."""

import importlib.util

import numpy as np
import pytest


def read_deck(path):
    """Return blocks [(keyword, parameters, rows of text fields)] in the order of the file."""
    blocks = []
    for line in path.read_text(encoding="ascii").splitlines():
        assert len(line) <= 256
        if line.startswith("**"):
            continue
        fields = [field.strip() for field in line.split(",")]
        if line.startswith("*"):
            parameters = dict(f.upper().partition("=")[::2] for f in fields[1:])
            blocks.append((fields[0][1:].upper(), parameters, []))
        else:
            assert len(fields) <= 16
            blocks[-1][2].append(fields)
    return blocks


def of_kind(blocks, keyword):
    return [(parameters, rows) for found, parameters, rows in blocks if found == keyword]


def points_of(blocks):
    ((_, rows),) = of_kind(blocks, "NODE")
    assert [int(row[0]) for row in rows] == list(range(1, len(rows) + 1))
    return np.array([[float(text) for text in row[1:]] for row in rows])


def elements_of(blocks):
    """Return {id: nodes} and {element set: ids}."""
    elements, sets = {}, {}
    for parameters, rows in of_kind(blocks, "ELEMENT"):
        table = np.array(rows, np.int64)
        elements |= {row[0]: row[1:] for row in table.tolist()}
        sets[parameters["ELSET"]] = table[:, 0].tolist()
    for parameters, rows in of_kind(blocks, "ELSET"):
        names = [field for row in rows for field in row]
        sets[parameters["ELSET"]] = [i for n in names for i in ([int(n)] if n.isdigit() else sets[n])]
    return elements, sets


def node_sets_of(blocks):
    return {p["NSET"]: [int(i) for row in rows for i in row] for p, rows in of_kind(blocks, "NSET")}


def surfaces_of(blocks):
    """Return {surface: {(element, face number from 1)}}."""
    _, sets = elements_of(blocks)
    return {
        p["NAME"]: {(element, int(side[1])) for name, side in rows for element in sets[name]}
        for p, rows in of_kind(blocks, "SURFACE")
    }


def load_judge(root):
    """Return the module of the independent judge beside the project; skip where it is missing."""
    path = root.parent / "shared" / "judge" / "judge_inp.py"
    if not path.is_file():
        pytest.skip("the judge of decks (../shared/judge) is not on this machine")
    spec = importlib.util.spec_from_file_location("judge_inp", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module

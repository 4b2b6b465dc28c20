"""The deck's own check finds each kind of breach in a deck of one tetrahedron."""

import re

import numpy as np
import pytest

from craftmesh.deck.check_deck import check_deck
from craftmesh.mesh.tet_connectivity import EDGE_CORNERS

DECK = """** one tetrahedron
*HEADING
one
*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 0., 1., 0.
4, 0., 0., 1.
*ELEMENT, TYPE=C3D4, ELSET=GRAIN_7
1, 1, 2,
 3, 4
*NSET, NSET=ZMIN
1, 2, 3
*MATERIAL, NAME=M
*ELASTIC
70., 0.3
*SOLID SECTION, ELSET=GRAIN_7, MATERIAL=M
"""


def breaches_of(tmp_path, deck: str) -> list[str]:
    path = tmp_path / "model.inp"
    path.write_bytes(deck.encode("latin-1"))
    return check_deck(path)


def test_sound_deck_has_no_breach(tmp_path):
    assert breaches_of(tmp_path, DECK) == []


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("one\n", "\xb5m\n", "not ASCII"),
        ("one\n", "x" * 257 + "\n", "line 3: over 256 characters"),
        ("2, 1., 0., 0.", "1, 1., 0., 0.", "1 node ids are duplicate"),
        (" 3, 4", " 3, 9", "line 9: node 9 is not in the deck"),
        ("1, 2, 3\n", "1, 2, 5\n", "line 12: node 5 is not in the deck"),
        ("1, 2, 3\n", "1, " * 16 + "1\n", "line 12: a row of the set has over 16 entries"),
        ("NSET=ZMIN", "NSET=" + "Z" * 81, "has over 80 characters"),
        ("ELSET=GRAIN_7, MATERIAL", "ELSET=GRAIN_8, MATERIAL", "names ELSET GRAIN_8"),
        ("MATERIAL=M", "MATERIAL=N", "names MATERIAL N"),
        ("1, 1, 2,", "1, 2, 1,", "1 elements have a volume <= 0 (the first is element 1 of GRAIN_7)"),
        ("*ELASTIC\n70., 0.3", "*USER MATERIAL, CONSTANTS=3\n70., 0.3", "CONSTANTS=3 but 2 values"),
        ("1, 1, 2,", "1, 1,", "line 9: rows of 4 numbers; expected 5"),
    ],
)
def test_each_breach_is_said(tmp_path, old, new, said):
    assert DECK.count(old) == 1
    found = breaches_of(tmp_path, DECK.replace(old, new))
    assert any(said in breach for breach in found)


PARTS = """*HEADING
*PART, NAME=BODY
*NODE, NSET=NALL
1, 0., 0., 0.
2, 1., 0., 0.
3, 0., 1., 0.
4, 0., 0., 1.
*ELEMENT, TYPE=C3D4, ELSET=GRAIN_7
1, 1, 2, 3, 4
*ELSET, ELSET=EALL
GRAIN_7
*ELSET, ELSET=ZMIN_S1
1
*SURFACE, NAME=ZMIN, TYPE=ELEMENT
ZMIN_S1, S1
*SOLID SECTION, ELSET=GRAIN_7, MATERIAL=M
*END PART
*ASSEMBLY, NAME=A
*INSTANCE, NAME=BODY-1, PART=BODY
*END INSTANCE
*NSET, NSET=TIP, INSTANCE=BODY-1
4
*END ASSEMBLY
*MATERIAL, NAME=M
*ELASTIC
70., 0.3
*STEP
*STATIC
*BOUNDARY
BODY-1.NALL, 3, 3
BODY-1.4, 1, 1
TIP, 2, 2
*DSLOAD
BODY-1.ZMIN, P, 1.
*NODE OUTPUT, NSET=BODY-1.NALL
*END STEP
"""


def test_a_sound_deck_of_parts_has_no_breach(tmp_path):
    assert breaches_of(tmp_path, PARTS) == []


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("BODY-1.NALL, 3", "NALL, 3", "no set .* NALL is defined before; expected BODY-1.NALL"),
        ("BODY-1.NALL, 3", "BODY-2.NALL, 3", "no set or surface BODY-2.NALL"),
        ("BODY-1.ZMIN,", "BODY-1.ZMAX,", "no set or surface BODY-1.ZMAX"),
        ("BODY-1.4,", "BODY-1.5,", "line 29: node 5 is not in the deck"),
        ("NSET=BODY-1.NALL\n*END", "NSET=NALL\n*END", "no set or surface NALL"),
        ("GRAIN_7\n*ELSET", "GRAIN_8\n*ELSET", "no set or surface GRAIN_8 is defined before"),
        ("*END PART\n", "", "the last part has no .END PART"),
        ("PART=BODY\n*END", "PART=BONE\n*END", "the part BONE of the instance is not defined"),
        (
            "*SOLID SECTION, ELSET=GRAIN_7, MATERIAL=M\n*END PART\n",
            "*END PART\n*SOLID SECTION, ELSET=GRAIN_7, MATERIAL=M\n",
            "SOLID SECTION is outside the parts",
        ),
        ("*END PART\n", "*MATERIAL, NAME=N\n*END PART\n", "MATERIAL is within a part"),
    ],
)
def test_each_breach_of_parts_is_said(tmp_path, old, new, said):
    assert PARTS.count(old) == 1
    found = breaches_of(tmp_path, PARTS.replace(old, new))
    assert any(re.search(said, breach) for breach in found), found


def split(tmp_path, mesh: str = "Mesh.inp") -> tuple:
    """Write DECK with its nodes, elements and node set in an included file; return both paths."""
    head, _, rest = DECK.partition("*NODE")
    middle, _, tail = rest.partition("*MATERIAL")
    model, included = tmp_path / "model.inp", tmp_path / mesh
    model.write_text(f"{head}*Include, input = {mesh}\n*MATERIAL{tail}")
    included.write_text("*NODE" + middle)
    return model, included


def test_included_files_are_read_and_named(tmp_path):
    model, included = split(tmp_path)
    assert check_deck(model) == []
    included.write_text(included.read_text().replace(" 3, 4", " 3, 9"))
    assert check_deck(model) == ["Mesh.inp, line 6: node 9 is not in the deck (1 such ids)"]
    model.write_text(model.read_text().replace("MATERIAL=M", "MATERIAL=N"))
    assert "line 8: the section names MATERIAL N, which is not in the deck" in check_deck(model)


def test_included_data_lines_belong_to_the_keyword_before(tmp_path):
    nodes = "1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n4, 0., 0., 1."  # no end of line
    deck = DECK.replace(nodes, "*INCLUDE, INPUT=nodes.txt")
    (tmp_path / "nodes.txt").write_text(nodes)
    assert breaches_of(tmp_path, deck) == []


def test_included_files_that_are_missing_or_go_round_are_said(tmp_path):
    model, included = split(tmp_path)
    included.write_text("*INCLUDE, INPUT=model.inp\n" + included.read_text())
    assert check_deck(model) == ["Mesh.inp, line 1: model.inp includes itself"]
    included.unlink()
    assert "line 4: the included file Mesh.inp does not exist" in check_deck(model)


def test_folded_ten_node_elements_are_named(tmp_path):
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    nodes = np.concatenate([corners, (corners[EDGE_CORNERS[:, 0]] + corners[EDGE_CORNERS[:, 1]]) / 2])
    for at, said in (
        (0.5, []),
        (2.0, ["Jacobian <= 0 at an integration point (the first is element 8 of"]),
    ):
        nodes[4, 1:] = at - 0.5  # the middle of the first edge
        lines = [f"{i}, {x}, {y}, {z}" for i, (x, y, z) in enumerate(nodes.tolist(), 1)]
        ids = ", ".join(map(str, range(1, 11)))
        deck = "\n".join(["*NODE", *lines, "*ELEMENT, TYPE=C3D10, ELSET=GRAIN_7", f"8, {ids}\n"])
        found = breaches_of(tmp_path, deck)
        assert len(found) == len(said) and all(text in breach for text, breach in zip(said, found)), found

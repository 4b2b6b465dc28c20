"""The deck's own check finds each kind of breach in a deck of one tetrahedron."""

import pytest

from craftmesh.deck.check_deck import check_deck

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
        ("2, 1., 0., 0.", "1, 1., 0., 0.", "1 node ids are there twice"),
        (" 3, 4", " 3, 9", "line 9: node 9 is not in the deck"),
        ("1, 2, 3\n", "1, 2, 5\n", "line 12: node 5 is not in the deck"),
        ("1, 2, 3\n", "1, " * 16 + "1\n", "line 12: a row of the set has over 16 entries"),
        ("NSET=ZMIN", "NSET=" + "Z" * 81, "has over 80 characters"),
        ("ELSET=GRAIN_7, MATERIAL", "ELSET=GRAIN_8, MATERIAL", "names ELSET GRAIN_8"),
        ("MATERIAL=M", "MATERIAL=N", "names MATERIAL N"),
    ],
)
def test_each_breach_is_said(tmp_path, old, new, said):
    assert DECK.count(old) == 1
    found = breaches_of(tmp_path, DECK.replace(old, new))
    assert any(said in breach for breach in found)

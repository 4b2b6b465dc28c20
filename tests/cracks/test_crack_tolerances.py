"""The budget of how far a crack may be off: shares add up, and the page has the same table."""

from pathlib import Path

import pytest

from craftmesh.cracks.crack_tolerances import PROMISED, SHARES, Off

PAGE = Path(__file__).resolve().parents[2] / "docs" / "architecture.md"


@pytest.mark.parametrize("kind", Off._fields)
def test_the_shares_add_up_to_no_more_than_is_promised(kind):
    assert sum(getattr(share, kind) for share in SHARES.values()) <= getattr(PROMISED, kind) * (1 + 1e-12)


def test_the_table_of_the_page_has_the_shares_in_the_order_in_which_they_are_spent():
    text = PAGE.read_text(encoding="utf-8")
    rows = [line.strip("| ").split(" | ") for line in text.splitlines() if line.startswith("| ")]
    stages = [*SHARES, "promised"]
    written = [(row[0], *map(float, row[1:3])) for row in rows if row[0] in stages]
    assert written == [(stage, *(SHARES | {"promised": PROMISED})[stage]) for stage in stages]

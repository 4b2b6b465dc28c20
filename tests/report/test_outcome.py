"""What the page says of a crack that has come to its end, or has not."""

import numpy as np

from craftmesh.report.outcome import increment_numbers, outcome

GROWN = {"ended": "", "extension": [0.4, 0.6]}


def test_a_crack_that_stops_says_where_and_why():
    growths = {"000": GROWN, "001": {"ended": "the crack severs the body", "extension": [0.4, 0.6]}}
    assert outcome(growths, 2) == "The crack stops after increment 001: the crack severs the body."
    assert outcome({"000": GROWN}, 2) == "2 increments, as many as were asked for."


def test_numbers_of_an_increment():
    rows = {"K_I": np.array([1.0, 3.0, np.nan]), "kink_angle": np.array([-4.0, 2.0, 1.0])}
    numbers = increment_numbers(rows, GROWN)
    assert (numbers["least_K_I"], numbers["largest_K_I"]) == (1.0, 3.0)
    assert (numbers["least_kink_angle"], numbers["largest_kink_angle"]) == (-4.0, 2.0)
    assert (numbers["least_extension"], numbers["largest_extension"]) == (0.4, 0.6)
    assert "largest_extension" not in increment_numbers(rows, None)
    assert "largest_extension" not in increment_numbers(rows, GROWN | {"ended": "it stops"})

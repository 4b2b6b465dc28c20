"""How messages write places."""

import numpy as np
import pytest

from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.series import prescribed_crack
from craftmesh.errors import CraftmeshError, rounded_values


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_a_place_is_told_well_enough_to_find_it_in_a_model_of_any_size(scale):
    places = scale * np.random.default_rng(0).uniform(-1, 1, (4, 3))
    assert np.allclose(rounded_values(places), places, rtol=1e-5, atol=0)
    assert max(len(str(abs(x))) for row in rounded_values(places) for x in row) <= len("1.23456e-09")


def test_a_refusal_in_a_small_model_says_where():
    box = np.array([[0.0, 0, 0], [1, 1, 1]]) * 1e-7 / 3
    with pytest.raises(CraftmeshError, match=r"\[3.33333e-08, 3.33333e-08, 3.33333e-08\]\]; the crack"):
        prescribed_crack(box, CrackOptions(centre=(0.0, 0.0, 1e-6), radius=1e-8))

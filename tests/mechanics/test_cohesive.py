"""Cohesive laws are read by name, and go from one unit of length to another."""

import pytest

from craftmesh.mechanics.cohesive import CohesiveLaw, parse_cohesive


def test_a_law_is_read_by_its_names_in_any_order_and_shears_are_as_normal_ones_where_not_given():
    whole = "all:energy=0.5,viscosity=1e-5,stiffness=1e6,eta=1.5,strength=300,shear_strength=200"
    laws = parse_cohesive([whole, "7-3:none", "low_angle:stiffness=2e6"])
    assert list(laws) == ["all", (3, 7), "low_angle"] and laws[3, 7] is None
    assert laws["all"] == CohesiveLaw(1e6, 1e6, 300.0, 200.0, 0.5, 0.5, 1.5, 1e-5)
    assert laws["low_angle"] == CohesiveLaw(2e6, 2e6)


def test_a_law_in_another_unit_of_length_has_the_same_stresses():
    law = parse_cohesive(
        ["all:stiffness=8,shear_stiffness=6,strength=4,energy=2,shear_energy=1,viscosity=9"]
    )
    scaled = law["all"].with_lengths(1000.0)
    assert (scaled.stiffness, scaled.shear_stiffness) == pytest.approx((8e-3, 6e-3))
    assert (scaled.energy, scaled.shear_energy) == pytest.approx((2e3, 1e3))
    assert (scaled.strength, scaled.shear_strength, scaled.viscosity, scaled.eta) == (4, 4, 9, 2)
    # a separation at full strength, strength / stiffness, and at failure, 2 energy / strength, are lengths
    assert scaled.strength / scaled.stiffness == pytest.approx(1000 * 4 / 8)
    assert scaled.energy / scaled.strength == pytest.approx(1000 * 2 / 4)

"""Lengths in another unit give the same mesh: a power of two changes no bit of its coordinates."""

from functools import cache

import numpy as np
import pytest
from models import voronoi

import craftmesh as cm


@cache
def meshed(exponent: int) -> list[cm.Surface]:
    """Return what remesh, insert_crack and gradate make of a model with lengths times 2**exponent."""
    factor = 2.0**exponent
    voxels = voronoi(5, 6, (8, 8, 8), spacing=(factor,) * 3, origin=(-3 * factor, 0.0, 5 * factor))
    plain, _ = cm.remesh(voxels)
    centre = (1.25 * factor, 3.875 * factor, 9.125 * factor)
    penny = cm.CrackOptions(centre=centre, normal=(0.25, 0.5, 1.0), radius=2.5 * factor)
    crack = cm.prescribed_crack(voxels.box, penny)
    lengths = cm.SizingOptions(l_min=0.75 * factor, l0=factor, l_max=2 * factor, r0=factor, r1=3 * factor)
    sizing = cm.sizing_around(plain, cm.Defects(crack), lengths)
    cut, _ = cm.insert_crack(plain, crack, sizing)
    fitted, _ = cm.gradate(cut, sizing, crack=crack)
    return [plain, cut, fitted]


@pytest.mark.parametrize("exponent", [-20, 20])
@pytest.mark.parametrize("stage", range(3), ids=["remesh", "insert_crack", "gradate"])
def test_a_power_of_two_changes_no_bit(exponent, stage):
    model, scaled = meshed(0)[stage], meshed(exponent)[stage]
    assert (scaled.points == np.ldexp(model.points, exponent)).all()
    for name in ("facets", "sides", "kind"):
        assert (getattr(scaled, name) == getattr(model, name)).all(), name
    assert stage == 0 or (model.kind == 7).any()

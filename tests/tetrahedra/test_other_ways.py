"""Where the first way leaves flat tets others are tried, the best is kept; without any nothing is tried."""

import numpy as np
from test_flat_places import pushed_box

from craftmesh.mesh.poor import is_flat
from craftmesh.tetrahedra import other_ways
from craftmesh.tetrahedra.opening_model import begun
from craftmesh.tetrahedra.other_ways import WAYS, opened_otherwise


def test_each_way_leaves_no_more_faults_than_there_were():
    before = begun(*pushed_box())
    for way in WAYS.values():
        assert other_ways._ended(way(other_ways._begun(before))).faults <= before.faults


def test_flat_tets_that_are_left_are_opened_by_another_way():
    before = begun(*pushed_box())
    assert before.count(is_flat) > 0
    best = opened_otherwise(before, before)
    assert best.count(is_flat) == 0 and best.faults < before.faults
    again = opened_otherwise(before, before)
    assert best.model.points.tobytes() == again.model.points.tobytes()


def test_without_flat_tets_or_with_too_many_no_other_way_is_tried(monkeypatch):
    sound = opened_otherwise(begun(*pushed_box()), begun(*pushed_box()))

    def never(now):
        raise AssertionError

    monkeypatch.setattr(other_ways, "WAYS", {"never": never})
    before = begun(*pushed_box())
    assert opened_otherwise(before, sound) is sound
    monkeypatch.setattr(other_ways, "MOST_LEFT", before.count(is_flat) - 1)
    assert opened_otherwise(before, before) is before


def test_ways_that_gain_nothing_are_not_kept(monkeypatch):
    before = begun(*pushed_box())
    monkeypatch.setattr(other_ways, "WAYS", {"nothing": lambda now: now})
    monkeypatch.setattr(other_ways, "_ended", lambda now: before)
    assert opened_otherwise(before, before) is before and np.isfinite(before.faults)

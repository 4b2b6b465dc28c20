"""Which nodes steer: by their flags, by the ends of their front, and where none can be trusted."""

import numpy as np
import pytest

from craftmesh.growth.extension import kinks_and_extensions
from craftmesh.growth.front_points import FrontPoints
from craftmesh.growth.kink_angle import kink_angles
from craftmesh.growth.options import GrowthOptions
from craftmesh.growth.trust import sources, trusted


@pytest.mark.parametrize(
    ("flags", "steers", "doubted"),
    [
        (["", "", ""], [1, 1, 1], False),
        (["limit+pierce", "", "short"], [0, 1, 0], False),
        (["error", "interface", ""], [0, 0, 1], False),
        (["end", "", "end+error"], [0, 1, 0], False),
        (["pierce", "narrow", "closed+mixed"], [1, 1, 1], False),
        (["error", "error", "error"], [1, 1, 1], True),
        (["error+pierce+limit", "error", "short"], [0, 1, 1], True),
        (["end+error", "pierce+error", "error"], [0, 0, 1], True),
        (["limit", "pierce+error", "end"], [1, 1, 1], True),
    ],
)
def test_flags_say_which_nodes_steer(flags, steers, doubted):
    found = trusted(flags)
    assert found.steers.tolist() == [bool(x) for x in steers] and bool(found.doubted) == doubted


def test_each_front_is_judged_for_itself():
    flags = ["error"] * 3 + ["", "error", "error"]
    found = trusted(flags, np.repeat([1.0, 2.0], 3))
    assert found.steers.tolist() == [True] * 4 + [False] * 2 and found.doubted == (1,)


def test_nodes_beside_the_end_of_a_front_do_not_steer():
    flags = ["end", *[""] * 8, "end"]
    steers = trusted(flags, np.ones(10), np.arange(10.0)).steers
    assert np.flatnonzero(steers).tolist() == [2, 3, 4, 5, 6, 7]
    doubtful = ["end+error", *["error"] * 8, "end+error"]
    assert (trusted(doubtful, np.ones(10), np.arange(10.0)).steers == steers).all()


def test_doubted_nodes_take_k_of_their_own_fronts_next_one():
    points = np.array([[x, y, 0.0] for y in (0.0, 0.4) for x in (0.0, 1.0, 2.0)])
    steers = np.array([False, False, True, True, True, True])
    assert sources(points, steers).tolist() == [3, 4, 2, 3, 4, 5]
    assert sources(points, steers, np.repeat([1, 2], 3)).tolist() == [2, 2, 2, 3, 4, 5]
    assert sources(points, np.zeros(6, bool)).tolist() == list(range(6))


TURN = np.arange(24) * 2 * np.pi / 24
PLACES = 6 * np.stack([np.cos(TURN), np.sin(TURN), 0 * TURN], axis=1)


def grown(k, flags):
    trust = trusted(flags, np.ones(24), 6 * TURN)
    known = {"points": PLACES, "doubt": np.full(24, 0.01), "trusted": trust.steers}
    front = FrontPoints.of(k, 6.0, **known)
    return kinks_and_extensions(front, GrowthOptions(extension=1.0))[0], trust


def test_a_front_whose_nodes_are_all_doubtful_turns_as_its_k_says():
    """K_II as of a tilted penny; where the front pierces a grain boundary K says anything."""
    k = np.stack([2 + 0 * TURN, 0.8 * np.cos(TURN), 0.3 * np.sin(TURN)], axis=1)
    flags = np.full(24, "error", object)
    flags[[5, 17]] = "pierce+limit+error"
    wild = k.copy()
    wild[[5, 17]] = [0.1, -3.0, 2.0]
    found, trust = grown(wild, flags.tolist())
    own = trust.steers
    assert trust.doubted and own.sum() == 22
    expected = kink_angles(k, "tangential_stress", 0.3)
    assert found.kink_angle[own] == pytest.approx(expected[own]) and np.abs(expected).max() > 0.5
    # pierce points go as the node beside them: 15 degrees on, where K_II is 0.21 less at most
    assert np.abs(found.kink_angle - expected).max() < 0.25
    assert (found.extension == 1.0).all() and (found.stays == "").all()


def test_what_a_doubted_node_has_counts_nowhere():
    k = np.tile([2.0, 0.3, 0.0], (24, 1))
    flags = np.full(24, "", object)
    flags[::3] = "short"
    wild = np.where((flags == "")[:, None], k, [-9.0, 5.0, 5.0])
    (found, _), (expected, _) = grown(wild, flags.tolist()), grown(k, flags.tolist())
    for name in ("kink_angle", "extension", "driving", "rate", "delta_k", "stays"):
        assert (getattr(found, name) == getattr(expected, name)).all()

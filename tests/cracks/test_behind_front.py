"""Which part of a plane is cracked: fronts carried on to the box, sides that witnesses tell, and holes."""

import numpy as np
import pytest
import shapely

from craftmesh.cracks.behind_front import Plane, cracked_part
from craftmesh.errors import CraftmeshError

BOX = np.array([[0.0, 0.0, 0.0], [10.0, 10.0, 10.0]])
NONE = np.zeros((0, 3))
# it ends inside the box, 0.3 from the faces across x; its last edges go on to them at 45 degrees
OPEN = np.array(
    [[0.3, -1.0], [1.0, -1.7], [3, -2.5], [5, -2.6], [6, -2.5], [8, -2.2], [9.2, -1.5], [9.7, -1]]
)


def tilted(degrees: float, axis: int = 0) -> Plane:
    """Return the plane through the middle of the box whose u is the axis."""
    turn = np.radians(degrees)
    across, normal = [0.0, np.cos(turn), np.sin(turn)], [0.0, -np.sin(turn), np.cos(turn)]
    frame = np.array([[1.0, 0.0, 0.0], across, normal])
    return Plane(np.roll([0.0, 5.0, 5.0], axis), np.roll(frame, axis, axis=1))


def lifted(plane: Plane, uv: np.ndarray) -> np.ndarray:
    return plane.lifted(np.column_stack([uv, np.zeros(len(uv))]))


@pytest.mark.parametrize("degrees", [0.0, 20.0])
@pytest.mark.parametrize("axis, step", [(0, 1), (0, -1), (1, 1), (2, 1)])
def test_an_open_front_goes_on_straight_to_the_box_whichever_way_it_runs(degrees, axis, step):
    plane = tilted(degrees, axis)
    front = lifted(plane, OPEN[::step])
    part = cracked_part([front], plane, BOX, NONE, np.zeros(1))
    assert shapely.distance(part.exterior, shapely.points([*OPEN, [0, -0.7], [10, -0.7]])).max() < 1e-9
    # then straight out of it, in the margin
    assert shapely.distance(part.exterior, shapely.points([[-0.5, -0.7], [10.5, -0.7]])).max() < 1e-9
    assert part.contains(shapely.Point(5, -3)) and not part.contains(shapely.Point(5, 0))
    place = lifted(plane, np.array([[5.0, 0.0], [5.0, 1.0], [5.0, -3.0]]))
    other = cracked_part([front], plane, BOX, place, np.zeros(1))
    assert other.contains(shapely.Point(5, 0)) and shapely.intersection(part, other).area < 1e-9
    # the margin is a twentieth of the box's diagonal, on all sides
    out = 0.05 * np.sqrt(300)
    assert shapely.union(part, other).bounds[::2] == pytest.approx((-out, 10 + out))


def test_closed_fronts_bound_what_is_within_the_largest_but_not_within_the_others():
    plane = tilted(20.0)
    square = np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]])
    rings = [
        lifted(plane, size * square + [5 + off, 0]) for size, off in ((0.5, 1.5), (3.0, 0.0), (1.0, -1.0))
    ]
    part = cracked_part(rings, plane, BOX, NONE, np.zeros(1))
    assert part.area == pytest.approx(36 - 1 - 4) and len(part.interiors) == 2
    beside = lifted(plane, square * 0.5 + [9.0, 0])
    with pytest.raises(CraftmeshError, match="bound several areas"):
        cracked_part([*rings, beside], plane, BOX, NONE, np.zeros(1))
    with pytest.raises(CraftmeshError, match="has 2 fronts, 1 of them open"):
        cracked_part([rings[0], lifted(plane, OPEN)], plane, BOX, NONE, np.zeros(1))

"""A path measured in a plane, swept across the box."""

import numpy as np
import pytest

from craftmesh.commands.crack import given_surface
from craftmesh.cracks.fitted_surface import crack_along_path
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.series import crack_of_increment
from craftmesh.errors import CraftmeshError

BOX = np.array([[-3.0, 0, 0], [17, 16, 12]])
X = np.linspace(1.0, 8.0, 60)
PATH = np.column_stack([X, 0.2 * np.sin(3 * X)])
OPTIONS = {
    "shape": "path",
    "scale": 2.0,
    "start": 3.0,
    "slant": 10.0,
    "centre": (-3.0, 8.0, 6.0),
    "radius": 5.0,
    "growth": 2.0,
}


def height(places):
    """Height (n,) over z = 6 at places (n, 3): the path between its points, and the slant of 10 degrees."""
    at = np.interp((places[:, 0] + 3) / 2 + 3, *PATH.T) - np.interp(3.0, *PATH.T)
    return 2 * at + np.tan(np.radians(10)) * (places[:, 1] - 8)


@pytest.mark.parametrize("increment", [0, 2])
def test_the_path_is_swept_along_its_slant_up_to_the_depth(increment):
    options = CrackOptions(**OPTIONS)
    surface, _ = crack_along_path(PATH, options, increment, BOX)
    crack = crack_of_increment(options, increment, BOX, surface)
    inside = ((crack.points >= BOX[0]) & (crack.points <= BOX[1])).all(axis=1)
    ahead = crack.points[:, 0] > -7  # the path begins there; before it the crack is level
    assert inside.sum() >= 2 and ahead.sum() > 2 * 25
    assert np.abs(crack.points[ahead, 2] - 6 - height(crack.points[ahead])).max() < 1e-9
    (front,) = crack.fronts
    ends = crack.points[front[[0, -1]]]
    assert np.allclose(ends[:, 0], -3 + 5 + 2 * increment) and sorted(ends[:, 1]) == [0, 16]
    corners = crack.points[crack.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (normal[:, 2] > 0).all()


def test_the_file_names_its_columns_and_faults_are_told(tmp_path):
    file = tmp_path / "path.csv"
    file.write_text("x,y\n" + "\n".join(f"{x:.17g},{y:.17g}" for x, y in PATH))
    options = CrackOptions(**OPTIONS, file=str(file))
    surface, _ = given_surface(options, 0, BOX)
    again, _ = crack_along_path(PATH, options, 0, BOX)
    assert np.array_equal(surface.points, again.points)
    with pytest.raises(CraftmeshError, match=r"turns back after its point 60, x = 8"):
        crack_along_path(np.concatenate([PATH, PATH[:1]]), options, 0, BOX)
    with pytest.raises(CraftmeshError, match="from -4 to 10 along the axis, .* 0 to 11"):
        crack_along_path(PATH, options, 3, BOX)
    file.write_text("x,z\n1,2\n")
    with pytest.raises(CraftmeshError, match="must name x, y$"):
        given_surface(options, 0, BOX)

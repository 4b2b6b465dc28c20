"""Wrong arrays at the library's door: one CraftmeshError of one line each, before anything is cast."""

import numpy as np
import pytest

from craftmesh import check_surface, gradate, insert_crack, sizing_for
from craftmesh.errors import CraftmeshError
from craftmesh.types import Crack, GrainTets, Solution, Surface, TetMesh, Voxels


class Body:
    """Another library's mesh: no array."""


POINTS = np.eye(4, 3)
TETS = np.array([[3, 0, 1, 2]])
DOORS = {
    "labels": lambda a: Voxels(a, (1, 1, 1), (0, 0, 0)),
    "phases": lambda a: Voxels(np.ones((1, 1, 1), int), (1, 1, 1), (0, 0, 0), None, a),
    "spacing": lambda a: Voxels(np.ones((1, 1, 1), int), a, (0, 0, 0)),
    "triangles": lambda a: Crack(POINTS, a, ()),
    "fronts": lambda a: Crack(POINTS, [[0, 1, 2]], (a,)),
    "crack points": lambda a: Crack(a, [[0, 1, 2]], ()),
    "facets": lambda a: Surface(POINTS, a, [[1, 0]], [0]),
    "facets of others": lambda a: Surface.of_facets(POINTS, a, [[1, 0]]),
    "sides": lambda a: Surface.of_facets(POINTS, [[0, 1, 2]], a),
    "surface points": lambda a: Surface(a, [[0, 1, 2]], [[1, 0]], [0]),
    "tets": lambda a: TetMesh(POINTS, a, [1]),
    "grain": lambda a: TetMesh(POINTS, TETS, a),
    "nodes": lambda a: GrainTets(1, a, np.zeros((0, 3)), TETS),
    "interior": lambda a: GrainTets(1, [], a, TETS),
    "displacement": lambda a: Solution(a, POINTS),
}  # fmt: skip
GOOD = {
    "labels": np.ones((2, 2, 2), int), "phases": np.array([0, 1]), "spacing": np.ones(3),
    "triangles": np.array([[0, 1, 2]]), "fronts": np.array([0, 1]), "crack points": POINTS,
    "facets": np.array([[0, 1, 2]]), "facets of others": np.array([[0, 1, 2]]), "sides": np.array([[1, 0]]),
    "surface points": POINTS, "tets": TETS, "grain": np.array([1]), "nodes": np.arange(4),
    "interior": POINTS, "displacement": POINTS,
}  # fmt: skip
IDS = {
    "labels",
    "phases",
    "triangles",
    "fronts",
    "facets",
    "facets of others",
    "sides",
    "tets",
    "grain",
    "nodes",
}


def put(array, value):
    changed = array.astype(float)
    changed.ravel()[-1] = value
    return changed


WRONG = {
    "not a number": (lambda a: put(a, np.nan), ("nan", "finite", "whole")),
    "infinite": (lambda a: put(a, np.inf), ("inf",)),
    "truth values": (lambda a: a.astype(bool), ("bool",)),
    "text": (lambda a: a.astype(str), ("<U",)),
    "complex": (lambda a: a.astype(complex), ("complex",)),
    "an object": (lambda a: Body(), ("Body",)),
    "none": (lambda a: None, ("NoneType",)),
    "ragged": (lambda a: [[1, 2, 3], [1]], ("unlike", "shape")),
    "another shape": (lambda a: a[None], ("shape",)),
}
WRONG_IDS = {
    "a fraction": (lambda a: put(a, 0.5), ("0.5",)),
    "too large": (lambda a: put(a, 3e19), ("whole numbers", "there are")),
    "too small": (lambda a: put(a, -3e19), ("whole numbers", "there are")),
}


@pytest.mark.parametrize("door", DOORS)
def test_wrong_arrays_are_refused_in_one_line_and_right_ones_are_not(door):
    DOORS[door](GOOD[door])
    DOORS[door](GOOD[door].tolist())
    DOORS[door](GOOD[door].astype(float))  # whole numbers as floats
    for name, (spoil, words) in (WRONG | (WRONG_IDS if door in IDS else {})).items():
        if (door, name) == ("phases", "none"):
            continue
        with pytest.raises(CraftmeshError) as error:
            DOORS[door](spoil(GOOD[door]))
        assert "\n" not in str(error.value) and any(w in str(error.value) for w in words), (
            name,
            error.value,
        )


@pytest.mark.parametrize("label", [3_000_000_000, -(2**31) - 1, np.uint64(2**63)])
def test_labels_do_not_wrap(label):
    with pytest.raises(
        CraftmeshError, match=f"labels holds {label}; expected whole numbers -2147483648 to"
    ):
        Voxels(np.full((1, 1, 1), label), (1, 1, 1), (0, 0, 0))


@pytest.mark.parametrize("crack", [[0], [1], np.ones(2, bool), "all"])
def test_what_facets_the_crack_has_is_a_truth_value_each(crack):
    with pytest.raises(CraftmeshError, match="expected a truth value for each of 1 facets"):
        Surface.of_facets(POINTS, [[0, 1, 2]], [[1, 1]], crack)


@pytest.mark.parametrize("function", [check_surface, gradate, insert_crack, sizing_for])
def test_other_objects_than_a_surface_are_refused_by_name(function):
    rest = {check_surface: (), gradate: (None,), insert_crack: (None,), sizing_for: (None, POINTS)}[
        function
    ]
    with pytest.raises(CraftmeshError, match="surface is a Body; expected Surface"):
        function(Body(), *rest)

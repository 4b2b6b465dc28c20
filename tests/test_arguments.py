"""Wrong arrays at the library's door: one CraftmeshError of one line each, before anything is cast."""

import numpy as np
import pytest

from craftmesh import Sizing, check_surface, crack_from_triangles, gradate, insert_crack, sizing_for
from craftmesh.assembly.assemble import assemble
from craftmesh.errors import CraftmeshError
from craftmesh.remeshing.remesh import remesh
from craftmesh.sizing.length_field import LengthField
from craftmesh.sizing.sizing import densify
from craftmesh.stitching.stitch import stitch_grains
from craftmesh.tetrahedra.grain_surface import grain_surfaces
from craftmesh.tetrahedra.options import TetrahedralizeOptions
from craftmesh.tetrahedra.tetrahedralize import tetrahedralize
from craftmesh.types import Crack, GrainTets, Solution, Surface, TetMesh, Voxels


class Body:
    """Another library's mesh: no array."""


POINTS = np.eye(4, 3)
TETS = np.array([[3, 0, 1, 2]])
BOX = np.array([[-2.0] * 3, [2.0] * 3])
HULL = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])[:, ::-1]
TETRAHEDRON = Surface.of_facets(POINTS, HULL, (1, 0))
SIZING = Sizing(1, 2, 3, 4, 5, 1, POINTS)
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
    "the crack's points": lambda a: crack_from_triangles(a, [[0, 1, 2]], None, BOX),
    "the crack's triangles": lambda a: crack_from_triangles(POINTS, a, None, BOX),
    "box": lambda a: crack_from_triangles(POINTS, [[0, 1, 2]], None, a),
    "frame": lambda a: crack_from_triangles(POINTS, [[0, 1, 3]], None, BOX, a),
    "a front": lambda a: crack_from_triangles(POINTS, [[0, 1, 2]], [a], BOX),
    "sources": lambda a: Sizing(1, 2, 3, 4, 5, 1, a),
    "points": lambda a: Sizing(1, 2, 3, 4, 5, 1, POINTS).at(a),
    "points of a field": lambda a: LengthField(POINTS, np.ones(4)).at(a),
    "a field's points": lambda a: LengthField(a, np.ones(4)),
    "a field's lengths": lambda a: LengthField(POINTS, a),
    "polyline": lambda a: densify(a, 1.0),
    "step": lambda a: densify(POINTS, a),
    "a grain's points": lambda a: stitch_grains([(1, a, HULL)]),
    "a grain's triangles": lambda a: stitch_grains([(1, POINTS, a)]),
    "a grain's id": lambda a: stitch_grains([(a, POINTS, HULL)]),
}  # fmt: skip
GOOD = {
    "labels": np.ones((2, 2, 2), int), "phases": np.array([0, 1]), "spacing": np.ones(3),
    "triangles": np.array([[0, 1, 2]]), "fronts": np.array([0, 1]), "crack points": POINTS,
    "facets": np.array([[0, 1, 2]]), "facets of others": np.array([[0, 1, 2]]), "sides": np.array([[1, 0]]),
    "surface points": POINTS, "tets": TETS, "grain": np.array([1]), "nodes": np.arange(4),
    "interior": POINTS, "displacement": POINTS,
    "the crack's points": POINTS, "the crack's triangles": np.array([[0, 1, 2]]), "box": BOX,
    "frame": np.eye(3), "a front": POINTS[[0, 1, 2, 0]], "sources": POINTS,
    "points": POINTS, "points of a field": POINTS, "a field's points": POINTS,
    "a field's lengths": np.ones(4), "polyline": POINTS, "step": np.array(1.0),
    "a grain's points": POINTS, "a grain's triangles": HULL, "a grain's id": np.array(1),
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
    "the crack's triangles",
    "a grain's triangles",
    "a grain's id",
}


def put(array, value):
    changed = array.astype(float)
    changed.ravel()[-1] = value
    return changed


WRONG = {
    "not a number": (lambda a: put(a, np.nan), ("nan", "finite", "whole")),
    "infinite": (lambda a: put(a, np.inf), ("inf",)),
    "beyond all lengths": (lambda a: put(a, 1e200), ("1e+200", "there are")),
    "truth values": (lambda a: a.astype(bool), ("bool",)),
    "text": (lambda a: a.astype(str), ("<U",)),
    "complex": (lambda a: a.astype(complex), ("complex",)),
    "an object": (lambda a: Body(), ("Body",)),
    "none": (lambda a: None, ("NoneType",)),
    "ragged": (lambda a: [[1, 2, 3], [1]], ("different", "shape")),
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
        if (door, name) in (("phases", "none"), ("frame", "none")):
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
    with pytest.raises(CraftmeshError, match="expected a boolean for each of 1 facets"):
        Surface.of_facets(POINTS, [[0, 1, 2]], [[1, 1]], crack)


UNLIKE = {
    "surface is a Body; expected Surface": [
        lambda: check_surface(Body()),
        lambda: gradate(Body(), None),
        lambda: insert_crack(Body(), None),
        lambda: sizing_for(Body(), POINTS, None),
        lambda: tetrahedralize(Body(), None, TetrahedralizeOptions()),
        lambda: assemble(Body(), []),
    ],
    "voxels is a Body; expected Voxels": [lambda: remesh(Body())],
    "grains is a Body; expected Sequence": [lambda: stitch_grains(Body())],
    r"grains\[1\] is a Body; expected tuple": [lambda: stitch_grains([(1, POINTS, HULL), Body()])],
    r"grains\[0\] has 2 items; expected 3": [lambda: stitch_grains([(1, POINTS)])],
    r"grain_tets\[0\] is a Body; expected GrainTets": [lambda: assemble(TETRAHEDRON, [Body()])],
    r"islands\[0\] is a str; expected Island": [
        lambda: tetrahedralize(TETRAHEDRON, None, TetrahedralizeOptions(), "x")
    ],
    "grains holds 1.5; expected whole": [lambda: grain_surfaces(TETRAHEDRON, [1.5])],
    r"others\[0\] is a Body; expected Lengths": [lambda: Sizing(1, 2, 3, 4, 5, 1, POINTS, None, (Body(),))],
    "volumes is a list; expected Mapping or None": [lambda: gradate(TETRAHEDRON, SIZING, volumes=[1.0])],
    "grains with target volumes is an array of": [lambda: gradate(TETRAHEDRON, SIZING, volumes={"a": 1.0})],
    "target volumes is an array of": [lambda: gradate(TETRAHEDRON, SIZING, volumes={1: "x"})],
    r"target volume of grain 1 is nan; expected a volume > 0": [
        lambda: gradate(TETRAHEDRON, SIZING, volumes={1: np.nan})
    ],
    "target volume of grain 2 is 1.0; .* that the surface bounds": [
        lambda: gradate(TETRAHEDRON, SIZING, volumes={1: 1.0, 2: 1.0})
    ],
    "polylines of 2 points or more": [
        lambda: crack_from_triangles(POINTS, [[0, 1, 2]], [], BOX),
        lambda: crack_from_triangles(POINTS, [[0, 1, 2]], [POINTS[:1]], BOX),
    ],
}


@pytest.mark.parametrize("words", UNLIKE)
def test_other_objects_are_refused_by_name(words):
    for call in UNLIKE[words]:
        with pytest.raises(CraftmeshError, match=words):
            call()

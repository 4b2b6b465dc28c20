"""What the library hands out can be pickled, copied and replaced; copies are read-only too."""

import copy
import dataclasses
import pickle
from collections.abc import Mapping

import numpy as np
import pytest
from structured_box import hexagon, plane_crack, structured_box

import craftmesh as cm
from craftmesh.errors import MeshingError
from craftmesh.sizing.length_field import LengthField
from craftmesh.types import Crystal, Solution
from craftmesh.voxels.generate import GenerateOptions, generate
from craftmesh.voxels.islands import find_islands

SURFACE, GRAIN_TETS = structured_box(
    (6, 6, 4), lambda centres: 1 + (centres[:, 0] > 3), plane_crack(2, 2, hexagon((3, 3), 2))
)
MESH, REPORT = cm.assemble(SURFACE, GRAIN_TETS)
VOXELS = dataclasses.replace(
    generate(GenerateOptions(shape=(16, 16, 16), grains=4, embedded_grains=1)),
    crystals={0: Crystal("cubic", "Cu")},
    voxel_orientations=np.ones((16, 16, 16, 4)),
)
CRACK = cm.prescribed_crack(SURFACE.box, cm.CrackOptions(centre=(3, 3, 2), radius=1.0))
SIZING = cm.Sizing(1, 2, 3, 4, 5, 1, np.eye(3), None, (LengthField(np.eye(3), np.ones(3)),))
THINGS = {
    "Voxels": VOXELS,
    "Crack": CRACK,
    "Surface": SURFACE,
    "TetMesh": MESH,
    "GrainTets": GRAIN_TETS[0],
    "Solution": Solution(np.eye(3), np.eye(3), {"solver": "builtin"}, np.eye(3), {"time": np.arange(3)}),
    "Sizing": SIZING,
    "Defects": cm.Defects(CRACK, np.eye(3)),
    "Island": find_islands(VOXELS)[0],
    "options": cm.DeckOptions(material=("isotropic:70000,0.33",)),
    "report": REPORT,
}
WAYS = {
    "pickle": lambda thing: pickle.loads(pickle.dumps(thing)),
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "replace": lambda thing: dataclasses.replace(thing) if dataclasses.is_dataclass(thing) else dict(thing),
}


def same(one: object, other: object) -> bool:
    """Tell whether two things hold the same values, arrays of one type and as little writable."""
    if isinstance(one, np.ndarray):
        flags = one.flags.writeable == other.flags.writeable
        return (
            flags
            and one.dtype == other.dtype
            and np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
        )
    if type(one) is not type(other):
        return False
    if dataclasses.is_dataclass(one):
        return all(same(getattr(one, f.name), getattr(other, f.name)) for f in dataclasses.fields(one))
    if isinstance(one, Mapping):
        return list(one) == list(other) and all(same(one[key], other[key]) for key in one)
    if isinstance(one, (tuple, list)):
        return len(one) == len(other) and all(map(same, one, other))
    return one == other


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", THINGS)
def test_a_copy_holds_the_same_and_is_as_read_only(name, way):
    assert same(THINGS[name], WAYS[way](THINGS[name]))


@pytest.mark.parametrize("name", [name for name in THINGS if name not in ("options", "report")])
def test_arrays_are_read_only_and_a_repr_is_one_short_line(name):
    thing = THINGS[name]
    arrays = [v for v in vars(thing).values() if isinstance(v, np.ndarray)]
    assert arrays and not any(array.flags.writeable for array in arrays)
    assert len(repr(thing)) < 250 and "array" not in repr(thing) and "\n" not in repr(thing)


def test_an_error_of_the_mesher_keeps_what_was_done():
    found = pickle.loads(pickle.dumps(MeshingError("grain 3", ("a",), (GRAIN_TETS[0],), {"made": 1})))
    assert str(found) == "grain 3" and found.failures == ("a",) and same(found.done[0], GRAIN_TETS[0])
    assert found.report == {"made": 1}


@pytest.mark.parametrize("name", ["Voxels", "Crack", "Surface", "TetMesh"])
def test_check_takes_any_of_the_things(name):
    assert cm.check(THINGS[name]) == []


def test_check_says_what_is_wrong_and_refuses_others():
    empty = dataclasses.replace(VOXELS, labels=np.zeros((16, 16, 16)))
    assert cm.check(empty) == ["no voxel belongs to a grain; expected labels > 0"]
    turned = dataclasses.replace(
        SURFACE, facets=SURFACE.facets[1:], sides=SURFACE.sides[1:], kind=SURFACE.kind[1:]
    )
    assert cm.check(turned) == cm.check_surface(turned) != []
    with pytest.raises(cm.CraftmeshError, match="thing is a ndarray; expected Voxels or Crack or Surface"):
        cm.check(np.eye(3))

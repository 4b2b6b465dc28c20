"""Materials, axes, contact and layers in the deck are those of the model, by plain tensors and units."""

from dataclasses import replace

import numpy as np
import pytest
from deck_reader import elements_of, of_kind, read_deck
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.assembly.boundary_layers import boundary_layers
from craftmesh.deck.check_deck import check_deck
from craftmesh.deck.write_deck import DeckOptions, write_deck, write_model
from craftmesh.mechanics.cohesive import CohesiveLayers, laws_of_pairs
from craftmesh.mechanics.model import elastic_model
from craftmesh.mechanics.orientation import random_orientations

PLACES = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]  # of the 21 constants, as Abaqus' manual has them
KINDS = {
    "cubic": "cubic:168400,121400,75400",
    "hexagonal": "hexagonal:162400,92000,69000,180700,46700",
    "sheared": "anisotropic:1e-3,-5e-4,2e-3,1e-3,3e-4,-7e-4",
    "straight": "orthotropic:1e-3,-5e-4,2e-3",
}


def mesh():
    def label_of(centres):
        return 1 + np.floor(centres[:, 0]).astype(int) + 3 * np.floor(centres[:, 1]).astype(int)

    return assemble(*structured_box((3, 3, 1), label_of))[0]


def tensor_of(upper):
    """The stiffness (3, 3, 3, 3) of 21 constants, column by column of the upper triangle."""
    values, found = iter(upper), np.zeros((3, 3, 3, 3))
    for column in range(6):
        for row in range(column + 1):
            (i, j), (k, l), value = PLACES[row], PLACES[column], next(values)
            for a, b in ((i, j), (j, i)):
                for c, d in ((k, l), (l, k)):
                    found[a, b, c, d] = found[c, d, a, b] = value
    return found


def turned(tensor, axes):
    """A tensor of any order in the sample's axes; columns of `axes` are its own axes there."""
    for place in range(tensor.ndim):
        tensor = np.moveaxis(np.tensordot(axes, tensor, (1, place)), 0, place)
    return tensor


def by_grain(path):
    """Stiffness and strain of each grain in the sample's axes, from the deck's text alone."""
    blocks, found = read_deck(path), {}
    axes = {p["NAME"]: np.array(rows[0], float).reshape(2, 3) for p, rows in of_kind(blocks, "ORIENTATION")}
    constants, name = {}, None
    for keyword, parameters, rows in blocks:
        name = parameters["NAME"] if keyword == "MATERIAL" else name
        if keyword in ("ELASTIC", "EXPANSION"):
            constants[name, keyword] = np.array([value for row in rows for value in row if value], float)
    for parameters, _ in of_kind(blocks, "SOLID SECTION"):
        first, second = axes[parameters["ORIENTATION"]]
        assert abs(first @ second) < 1e-14 and np.allclose([first @ first, second @ second], 1, atol=1e-14)
        own = np.stack([first, second, np.cross(first, second)], axis=1)
        material = parameters["MATERIAL"]
        strain = np.diag(constants[material, "EXPANSION"])
        found[parameters["ELSET"]] = (
            turned(tensor_of(constants[material, "ELASTIC"]), own),
            turned(strain, own),
        )
    return found


def rotation(quaternion):
    w, *v = quaternion
    cross = np.cross(v, np.eye(3)).T  # turns a vector u into v x u
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross


@pytest.mark.parametrize("material", ["cubic", "hexagonal"])
@pytest.mark.parametrize("strain", ["sheared", "straight"])
def test_stiffness_and_eigenstrain_in_the_sample_are_those_that_were_given(material, strain, tmp_path):
    turns = random_orientations(10, np.random.default_rng(8))
    options = DeckOptions(load="none", material=(KINDS[material],), eigenstrain=(KINDS[strain],))
    write_deck(tmp_path / "model.inp", mesh(), options, turns)
    c = [float(number) for number in KINDS[material].partition(":")[2].split(",")]
    c11, c12, c13, c33, c44 = c if material == "hexagonal" else (c[0], c[1], c[1], c[0], c[2])
    c66 = (c11 - c12) / 2 if material == "hexagonal" else c44
    # D1111, D1122, D2222, D1133, D2233, D3333, then 1212, 1313 and 2323 on the diagonal
    shears = [0, 0, 0, c66, 0, 0, 0, 0, c44, 0, 0, 0, 0, 0, c44]
    stiffness = tensor_of([c11, c12, c11, c13, c13, c33, *shears])
    numbers = [float(number) for number in KINDS[strain].partition(":")[2].split(",")]
    own = np.diag(numbers[:3])
    for (row, column), shear in zip(PLACES[3:], numbers[3:]):
        own[row, column] = own[column, row] = shear
    found = by_grain(tmp_path / "model.inp")
    assert len(found) == 9
    for grain in range(1, 10):
        axes = rotation(turns[grain])
        stiff, strained = found[f"GRAIN_{grain}"]
        # numbers of 20 characters keep 13 digits or more
        assert np.abs(stiff - turned(stiffness, axes)).max() < 1e-11 * c11
        assert np.abs(strained - turned(own, axes)).max() < 1e-14


def test_a_strain_given_in_the_sample_by_grain_is_written_with_its_own_axes(tmp_path):
    # half of all principal axes as numpy finds them are left-handed
    rng = np.random.default_rng(5)
    strains = {grain: (lambda e: (e + e.T) * 1e-3)(rng.normal(size=(3, 3))) for grain in range(1, 10)}
    options = DeckOptions(load="none", material=(KINDS["cubic"],), eigenstrain_file="strains.csv")
    turns = random_orientations(10, rng)
    model, _ = elastic_model(mesh(), options, turns, grain_strains=strains)
    write_model(tmp_path / "model.inp", model, options)
    shears = [0, 0, 0, 75400, 0, 0, 0, 0, 75400, 0, 0, 0, 0, 0, 75400]
    stiffness = tensor_of([168400, 121400, 168400, 121400, 121400, 168400, *shears])
    for grain, (stiff, strained) in by_grain(tmp_path / "model.inp").items():
        number = int(grain.removeprefix("GRAIN_"))
        assert np.abs(strained - strains[number]).max() < 1e-14
        assert np.abs(stiff - turned(stiffness, rotation(turns[number]))).max() < 1e-11 * 168400


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_the_contact_of_lips_is_as_stiff_in_every_unit_of_length_and_of_stress(factor, tmp_path):
    """Contact is stress over length: overlaps stay the same share of the body."""
    crack = plane_crack(2, 2, hexagon((2, 2), 1))
    stiffness = []
    for name, edge, young in (("one", 1.0, 1.0), ("length", factor, 1.0), ("stress", 1.0, factor)):
        body = assemble(*structured_box((4, 4, 4), lambda c: np.ones(len(c), int), crack, (edge,) * 3))[0]
        options = DeckOptions(lip_contact=True, load="stress", material=(f"isotropic:{young!r},0.3",))
        write_deck(tmp_path / f"{name}.inp", body, options)
        ((_, rows),) = of_kind(read_deck(tmp_path / f"{name}.inp"), "SURFACE BEHAVIOR")
        stiffness.append(float(rows[0][0]))
    assert stiffness[1:] == pytest.approx([stiffness[0] / factor, stiffness[0] * factor], rel=1e-12)


def test_cohesive_layers_have_ids_of_their_own_and_each_pair_has_its_law(tmp_path):
    body = assemble(*structured_box((3, 1, 1), lambda c: 1 + c[:, 0].astype(int)))[0]
    model, _ = elastic_model(body, DeckOptions(load="strain"))
    texts = ["all:stiffness=5,strength=2,energy=3", "2-3:stiffness=7"]
    laws = laws_of_pairs(texts, [(1, 2), (2, 3)], model)
    opened, elements = boundary_layers(model.mesh, laws)
    layers = CohesiveLayers(laws, elements)
    write_model(tmp_path / "m.inp", replace(model, mesh=opened), DeckOptions(cohesive=texts), layers=layers)
    assert check_deck(tmp_path / "m.inp") == []  # normals out of the solid elements among others
    blocks = read_deck(tmp_path / "m.inp")
    by_id, sets = elements_of(blocks)
    assert sorted(by_id) == list(range(1, len(opened.tets) + sum(map(len, elements.values())) + 1))
    for (a, b), rows in elements.items():
        assert [by_id[i] for i in sets[f"COH_{a}_{b}"]] == (rows + 1).tolist()
    assert sets["COH_ALL"] == [*sets["COH_1_2"], *sets["COH_2_3"]]
    values, name = {}, ""
    for keyword, parameters, rows in blocks:
        name = parameters["NAME"] if keyword == "MATERIAL" else name
        if keyword == "ELASTIC":
            values[name] = [float(value) for value in rows[0]]
    of_pair = {p["ELSET"]: values[p["MATERIAL"]] for p, _ in of_kind(blocks, "COHESIVE SECTION")}
    assert of_pair == {"COH_1_2": [5.0] * 3, "COH_2_3": [7.0] * 3}

"""Cohesive layers: what comes apart, what joins it, and what passes through it."""

from dataclasses import replace

import numpy as np
import pytest
from deck_reader import of_kind, read_deck
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.assembly.boundary_layers import boundary_layers, grain_pairs
from craftmesh.deck.check_deck import check_deck
from craftmesh.deck.options import DeckOptions
from craftmesh.deck.write_deck import write_model
from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.cohesive import CohesiveLaw, CohesiveLayers, laws_of_pairs, parse_cohesive
from craftmesh.mechanics.load import nodal_forces
from craftmesh.mechanics.model import elastic_model
from craftmesh.mesh.integration import DECK_RULE
from craftmesh.mesh.second_order import raise_order
from craftmesh.solve.problem import elements_of
from craftmesh.surface.measure import area_vectors

BOUNDARY_AT_2 = (2, 2, 4), lambda c: np.where(c[:, 2] < 2, 1, 2)


def layered(model, quadratic, pairs=None):
    """Return the mesh before, the opened mesh and its elements."""
    mesh = assemble(*structured_box(*model))[0]
    mesh = raise_order(mesh) if quadratic else mesh
    return mesh, *boundary_layers(mesh, grain_pairs(mesh) if pairs is None else pairs)


@pytest.mark.parametrize("quadratic", [False, True])
def test_layers_lie_in_the_boundaries_and_point_from_the_lower_grain(quadratic):
    model = (4, 4, 4), lambda c: 1 + (c[:, 0] > 2) + 2 * (c[:, 1] > 2)
    before, mesh, layers = layered(model, quadratic)
    assert set(layers) == {(1, 2), (1, 3), (2, 4), (3, 4)}
    assert (mesh.tets[:, 0] >= 0).all() and np.array_equal(
        mesh.points[mesh.tets], before.points[before.tets]
    )
    grain_of = np.zeros(len(mesh.points), int)
    grain_of[mesh.tets] = mesh.grain[:, None]
    middle = {g: mesh.points[mesh.tets[mesh.grain == g, :4]].mean(axis=(0, 1)) for g in range(1, 5)}
    for (a, b), rows in layers.items():
        assert len(rows) == (64 if not quadratic else 256) // 4
        assert np.array_equal(mesh.points[rows[:, :3]], mesh.points[rows[:, 3:]])
        assert (grain_of[rows[:, :3]] == a).all() and (grain_of[rows[:, 3:]] == b).all()
        vectors = area_vectors(mesh.points, rows[:, :3])
        assert (vectors @ (middle[b] - middle[a]) > 0).all()
        assert np.linalg.norm(vectors, axis=1).sum() == pytest.approx(8, rel=1e-12)
        assert len(np.unique(np.sort(rows, axis=1), axis=0)) == len(rows)


@pytest.mark.parametrize("quadratic", [False, True])
@pytest.mark.parametrize(
    ("label_of", "copies"),
    [
        (lambda c: np.where(c[:, 0] < 2, 1, 2 + (c[:, 1] > 2)), 3),  # a triple line along z
        (lambda c: np.where(c[:, 2] < 2, 1, np.where(c[:, 0] < 2, 2, 3 + (c[:, 1] > 2))), 4),
    ],
)
def test_junctions_come_apart_into_one_node_a_grain(quadratic, label_of, copies):
    _, mesh, _ = layered(((4, 4, 4), label_of), quadratic)
    at = np.flatnonzero((mesh.points == (2, 2, 2)).all(axis=1))
    assert len(at) == copies
    assert set(np.concatenate([mesh.grain[(mesh.tets == node).any(axis=1)] for node in at])) == set(
        range(1, copies + 1)
    )


def test_a_crack_in_the_boundary_has_no_layer_and_its_front_is_there_on_both_sides():
    crack = plane_crack(2, 2, hexagon((2, 2), 1))
    before, mesh, layers = layered(((4, 4, 4), lambda c: np.where(c[:, 2] < 2, 1, 2), crack), True)
    area = np.linalg.norm(area_vectors(mesh.points, layers[1, 2][:, :3]), axis=1).sum()
    lip = mesh.outward_triangles("CRACK_LIP_A")[:, :3]
    cracked = np.linalg.norm(area_vectors(mesh.points, lip), axis=1).sum()
    assert area == pytest.approx(16 - cracked, rel=1e-12)
    assert np.array_equal(mesh.node_sets["CRACK_FRONT"], before.node_sets["CRACK_FRONT"])
    front, copies = (mesh.points[mesh.node_sets[name]] for name in ("CRACK_FRONT", "CRACK_FRONT_COPIES"))
    assert np.array_equal(np.unique(front, axis=0), np.unique(copies, axis=0))
    lips = [set(mesh.tets[mesh.grain == g].ravel()) for g in (1, 2)]
    assert set(mesh.node_sets["CRACK_FRONT"]) <= lips[0] and not lips[0] & lips[1]


def test_a_crack_across_a_boundary_leaves_up_to_four_nodes_in_a_place():
    crack = plane_crack(2, 2, hexagon((2, 2), 1))
    _, mesh, layers = layered(((4, 4, 4), lambda c: np.where(c[:, 0] < 2, 1, 2), crack), True)
    assert np.count_nonzero((mesh.points == (2, 2, 2)).all(axis=1)) == 4
    assert np.linalg.norm(area_vectors(mesh.points, layers[1, 2][:, :3]), axis=1).sum() == pytest.approx(16)
    at = np.flatnonzero((mesh.points == (2, 2, 2)).all(axis=1))
    assert set(at) <= set(mesh.node_sets["CRACK_LIP_A"]) | set(mesh.node_sets["CRACK_LIP_B"])


def test_where_some_boundaries_are_chosen_the_rest_stay_welded():
    model = (4, 4, 4), lambda c: np.where(c[:, 0] < 2, 1, 2 + (c[:, 1] > 2))
    before, mesh, layers = layered(model, True, [(2, 3)])
    assert list(layers) == [(2, 3)] and not (layers[2, 3][:, :3] == layers[2, 3][:, 3:]).all(axis=1).any()
    assert np.count_nonzero((mesh.points == (2, 2, 2)).all(axis=1)) == 1  # its rim
    assert np.count_nonzero((mesh.points == (4, 2, 2)).all(axis=1)) == 2
    for axis, name in enumerate(("XMAX", "YMAX", "ZMAX")):
        assert np.array_equal(np.sort(mesh.node_sets[name]), np.flatnonzero(mesh.points[:, axis] == 4))


def solved(welded, mesh, layers, stiffness, element):
    """Return the displacements under a uniform tension of 1 along z, layers as linear triangles."""
    options = DeckOptions(
        element=element,
        material=("isotropic:1000,0.3",),
        faces=("ZMAX.z=stress:1", "XMIN.x=fixed", "YMIN.y=fixed", "ZMIN.z=fixed"),
    )
    model = replace(elastic_model(welded, options)[0], mesh=mesh)
    elements, size = elements_of(model, DECK_RULE), 3 * len(mesh.points)
    matrix = np.array([elements.forces(unit.reshape(-1, 3)).ravel() for unit in np.eye(size)])
    for rows in layers:
        area = np.linalg.norm(area_vectors(mesh.points, rows[None, :3]))
        for i in range(3):
            for j in range(3):
                part = stiffness * area * (1 + (i == j)) / 12 * np.eye(3)
                for p, q, sign in ((0, 0, 1), (3, 3, 1), (0, 3, -1), (3, 0, -1)):
                    a, b = 3 * rows[i + p], 3 * rows[j + q]
                    matrix[a : a + 3, b : b + 3] += sign * part
    forces = nodal_forces(model.load.pulled, mesh).ravel()
    free = np.ones(size, bool)
    for fixed in model.load.held:
        free[3 * mesh.node_sets[fixed.name] + fixed.axis] = False
    found = np.zeros(size)
    found[free] = np.linalg.solve(matrix[np.ix_(free, free)], forces[free])
    return found.reshape(-1, 3)


def test_a_uniform_traction_passes_through_linear_elements_exactly():
    welded, mesh, layers = layered(BOUNDARY_AT_2, False)
    rows = layers[1, 2]
    u = solved(welded, mesh, rows, 50.0, "C3D4")
    apart = (u[rows[:, 3:]] - u[rows[:, :3]]).reshape(-1, 3)
    assert np.abs(apart - [0, 0, 1 / 50]).max() < 1e-9 / 50


def test_through_quadratic_ones_it_passes_in_the_mean_and_a_stiff_layer_welds():
    welded, mesh, layers = layered(((1, 1, 2), lambda c: np.where(c[:, 2] < 1, 1, 2)), True)
    rows = layers[1, 2]
    area = np.linalg.norm(area_vectors(mesh.points, rows[:, :3]), axis=1)
    for stiffness, swing in ((50.0, 0.05), (1e9, 3.0)):  # times the edge over E: 0.05 and 1e6
        u = solved(welded, mesh, rows, stiffness, "C3D10")
        apart = stiffness * (u[rows[:, 3:]] - u[rows[:, :3]])[..., 2]
        assert np.average(apart.mean(axis=1), weights=area) == pytest.approx(1, rel=1e-5)
        assert (
            np.abs(apart - 1).max() < swing
        )  # corners and mid nodes share a face otherwise than triangles
    uniform = mesh.points * [-0.3e-3, -0.3e-3, 1e-3]
    assert np.abs(u - uniform).max() < 1e-5 * np.abs(uniform).max()


LAW = "stiffness=1e6,strength=300,energy=0.5"


def test_the_deck_has_elements_sections_and_laws(tmp_path):
    model, _ = elastic_model(layered(BOUNDARY_AT_2, True)[0], DeckOptions(material=("isotropic:1000,0.3",)))
    laws = laws_of_pairs([f"1-2:{LAW},shear_energy=0.7,viscosity=1e-5"], [(1, 2)], model)
    opened, elements = boundary_layers(model.mesh, laws)
    options = DeckOptions(cohesive=("all:stiffness=1",), scale=1000.0)
    write_model(
        tmp_path / "m.inp",
        replace(model, mesh=opened, scale=1000.0),
        options,
        layers=CohesiveLayers(laws, elements),
    )
    assert check_deck(tmp_path / "m.inp") == []
    blocks = read_deck(tmp_path / "m.inp")
    found = {p["ELSET"]: np.array(r, int) for p, r in of_kind(blocks, "ELEMENT") if p["TYPE"] == "COH3D6"}
    assert np.array_equal(found["COH_1_2"][:, 1:], elements[1, 2] + 1)
    assert found["COH_1_2"][:, 0].tolist() == list(np.arange(len(elements[1, 2])) + len(opened.tets) + 1)
    ((section, _),) = of_kind(blocks, "COHESIVE SECTION")
    assert section["RESPONSE"] == "TRACTION SEPARATION" and section["ELSET"] == "COH_1_2"
    assert ({"TYPE": "TRACTION"}, [["1000.0"] * 3]) in of_kind(blocks, "ELASTIC")  # stress / length
    assert of_kind(blocks, "DAMAGE INITIATION")[0][1] == [["300.0"] * 3]
    assert of_kind(blocks, "DAMAGE EVOLUTION")[0][1] == [["500.0", "700.0", "700.0"]]  # stress * length
    assert float(of_kind(blocks, "SECTION CONTROLS")[0][0]["VISCOSITY"]) == 1e-5


def test_the_narrowest_scope_gives_the_law():
    model = (3, 1, 1), lambda c: 1 + c[:, 0].astype(int)
    mesh = assemble(*structured_box(model[0], model[1]))[0]
    turns = np.zeros((4, 4))
    half = np.radians([0, 0, 80, 40]) / 2  # about z: a cubic crystal at 80 is at -10
    turns[:, 0], turns[:, 3] = np.cos(half), np.sin(half)
    cubic, _ = elastic_model(mesh, DeckOptions(material=("cubic:168e3,121e3,75e3",)), turns)
    pairs = [(1, 2), (2, 3)]
    rows = [f"all:{LAW}", "low_angle:stiffness=2e6"]
    laws = laws_of_pairs(rows, pairs, cubic)
    assert laws[1, 2] == CohesiveLaw(2e6) and laws[2, 3].strength == 300
    assert laws_of_pairs([*rows, "2-1:none"], pairs, cubic).keys() == {(2, 3)}
    even, _ = elastic_model(mesh, DeckOptions(material=("isotropic:1000,0.3",)))
    with pytest.raises(CraftmeshError, match="low_angle: the disorientation of grains 1 and 2 is unknown"):
        laws_of_pairs(rows, pairs, even)
    with pytest.raises(CraftmeshError, match="1-3: these grains share no face"):
        laws_of_pairs(["1-3:stiffness=1"], pairs, even)


@pytest.mark.parametrize(
    "text",
    ["", "all", "1-1:none", "some:none", "all:strength=1", "all:stiffness=0", "all:stiffness=1,strength=3"],
)
def test_other_rows_are_refused(text):
    with pytest.raises(CraftmeshError, match="^cohesive: .*expected all:"):
        parse_cohesive([text])


ONE = """*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 0., 1., 0.
4, 0., 0., -1.
5, 0., 0., 0.
6, 1., 0., 0.
7, 0., 1., 0.
*ELEMENT, TYPE=C3D4, ELSET=GRAIN_1
1, 1, 3, 2, 4
*ELEMENT, TYPE=COH3D6, ELSET=COH_1_2
2, 1, 2, 3, 5, 6, 7
*MATERIAL, NAME=M
*COHESIVE SECTION, ELSET=COH_1_2, MATERIAL=M, RESPONSE=TRACTION SEPARATION
"""


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("", "", None),
        ("COH3D6", "COH3D15", "Abaqus has no COH3D15"),
        ("5, 6, 7\n", "5, 7, 6\n", "nodes 4 to 6 not over 1 to 3"),
        ("1, 2, 3, 5, 6, 7\n", "1, 3, 2, 5, 7, 6\n", "into the solid element"),
        ("SECTION, ELSET=COH_1_2", "SECTION, ELSET=GRAIN_1", "no cohesive section covers elements of COH"),
        ("MATERIAL=M, R", "MATERIAL=N, R", "names MATERIAL N"),
    ],
)
def test_check_knows_cohesive_elements(tmp_path, old, new, said):
    (tmp_path / "m.inp").write_text(ONE.replace(old, new))
    found = check_deck(tmp_path / "m.inp")
    assert found == [] if said is None else any(said in breach for breach in found), found

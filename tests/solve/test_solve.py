"""The built-in solver finds the fields that are known, and refuses what has none."""

from dataclasses import replace

import numpy as np
import pytest
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.load import Fixed, Load, Traction
from craftmesh.mechanics.model import ElasticModel, elastic_model
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.mechanics.orientation import random_orientations
from craftmesh.mesh.mesh_sets import LIPS
from craftmesh.solve.options import SolveOptions
from craftmesh.solve.problem import problem_of, supports_of
from craftmesh.solve.solve import memory_of, solve
from craftmesh.types import TetMesh

COPPER = ("cubic:168.4e3,121.4e3,75.4e3",)
EXACT = SolveOptions(tolerance=1e-12)
FULL = replace(EXACT, integration="full")  # four points are not exact over curved elements
STRAIN = 1e-3 * np.array([[1.0, 0.3, -0.2], [0.3, -0.5, 0.4], [-0.2, 0.4, 0.8]])


def two_grains(centres):
    return np.where(centres[:, 0] < 3, 1, 2)


def cracked(shape=(6, 6, 4), label_of=two_grains) -> TetMesh:
    crack = plane_crack(2, shape[2] / 2, hexagon((3, 3), 2))
    return assemble(*structured_box(shape, label_of, crack, (0.5, 1 / 3, 0.4), (-0.7, 12.0, 3.0)))[0]


def block(shape=(3, 4, 5)) -> TetMesh:
    return assemble(*structured_box(shape, two_grains, None, (0.5, 1 / 3, 0.4), (-0.7, 12.0, 3.0)))[0]


def copper(mesh: TetMesh, seed: int = 1, **options) -> ElasticModel:
    """A model of randomly oriented copper grains."""
    orientations = random_orientations(3, np.random.default_rng(seed))
    return elastic_model(mesh, ModelOptions(material=COPPER, **options), orientations)[0]


def one_crystal(model: ElasticModel) -> ElasticModel:
    """The same model with the orientation of grain 1 in all grains."""
    return replace(model, axes=dict.fromkeys(model.grains.tolist(), model.axes[1]))


def outside(mesh: TetMesh) -> np.ndarray:
    return np.unique(np.concatenate([mesh.node_sets[x + end] for x in "XYZ" for end in ("MIN", "MAX")]))


def moved_by(mesh: TetMesh, nodes: np.ndarray, field: np.ndarray) -> Load:
    return Load((), moved=tuple(Fixed(nodes, axis, field[nodes, axis]) for axis in range(3)))


def jiggled(mesh: TetMesh, still: np.ndarray) -> TetMesh:
    """The mesh with its nodes moved at random by up to a few percent of an edge, those of `still` kept."""
    moves = 0.02 * np.random.default_rng(0).uniform(-1, 1, mesh.points.shape)
    moves[still] = 0
    return TetMesh(mesh.points + moves, mesh.tets, mesh.grain, mesh.node_sets, mesh.face_sets)


def off_linear(model: ElasticModel, nodes: np.ndarray, exact: np.ndarray) -> float:
    """How far the solver is from the field `exact` inside when `nodes` are moved by it.

    Random moves come on top of it and are taken off again: it would start from a linear field alone.
    """
    noise = size(exact) * np.random.default_rng(2).uniform(-1, 1, exact.shape)
    fields = []
    for field in (exact + noise, noise):
        solution, report = solve(replace(model, load=moved_by(model.mesh, nodes, field)), FULL)
        assert report["iterations"] > 0
        fields.append(solution.displacement)
    return size(fields[0] - fields[1] - exact)


def size(field: np.ndarray) -> float:
    return float(np.abs(field).max())


@pytest.mark.parametrize("element", ["C3D4", "C3D10"])
def test_a_linear_field_on_the_outside_is_linear_inside(element):
    model = one_crystal(copper(block(), element=element))
    still = outside(model.mesh)
    mesh = jiggled(model.mesh, still)  # edges are curved then
    exact = (mesh.points - mesh.points.mean(axis=0)) @ STRAIN
    assert off_linear(replace(model, mesh=mesh), still, exact) <= 1e-10 * size(exact)


def test_quarter_points_carry_linear_fields_through_the_crack():
    model = one_crystal(copper(cracked(), quarter_points=True))
    mesh = model.mesh
    lips = np.unique(np.concatenate([mesh.node_sets[lip] for lip in LIPS]))
    exact = mesh.points @ STRAIN
    assert off_linear(model, np.union1d(outside(mesh), lips), exact) <= 1e-10 * size(exact)


@pytest.mark.parametrize("element", ["C3D4", "C3D10"])
@pytest.mark.parametrize("load", ["strain", "stress"])
def test_a_bar_strains_as_hooke_says(element, load):
    mesh = block()
    options = ModelOptions(element=element, load=load, magnitude=70.0 if load == "stress" else 1e-3)
    model, _ = elastic_model(mesh, options)
    solution, _ = solve(model, EXACT)
    points = model.mesh.points - model.mesh.points.min(axis=0)
    # the corner that is held has the lowest x and y
    assert np.abs(solution.displacement - points * [-3.3e-4, -3.3e-4, 1e-3]).max() <= 1e-12
    pull = solution.reactions[model.mesh.node_sets["ZMIN"], 2].sum()
    assert pull == pytest.approx(-70 * np.prod(points.max(axis=0)[:2]), rel=1e-9)


@pytest.mark.parametrize("quarter_points", [False, True])
@pytest.mark.parametrize(("load", "magnitude"), [("strain", 0.01), ("stress", 50.0)])
def test_reactions_and_loads_are_in_balance(load, magnitude, quarter_points):
    loaded = {"load": load, "magnitude": magnitude, "sides": "rollers"}
    model = copper(cracked(), quarter_points=quarter_points, **loaded)
    solution, report = solve(model)
    assert report["residual"] <= 1e-8 and report["iterations"] < 60
    forces = solution.reactions + problem_of(model).forces
    largest = np.abs(forces).sum(axis=0).max()
    # forces and moments of what is out of balance: 1e-8 of the forces at each of some thousand nodes
    assert np.abs(forces.sum(axis=0)).max() <= 1e-6 * largest
    turning = np.cross(model.mesh.points - model.mesh.points.mean(axis=0), forces)
    assert np.abs(turning.sum(axis=0)).max() <= 1e-6 * largest
    free = ~problem_of(model).supports.fixed
    assert (solution.reactions[free] == 0).all()


def test_pressure_on_the_lips_opens_the_crack_as_tension_far_away_does():
    """Superposition: tension outside is uniform tension plus a pressure on the lips."""
    model, _ = elastic_model(cracked(), ModelOptions(load="stress", magnitude=50.0))
    mesh = model.mesh
    far, _ = solve(model, EXACT)
    pressure = tuple(Traction(mesh.face_sets[lip], -50.0, lip) for lip in LIPS)
    near, _ = solve(replace(model, load=Load(model.load.held, pulled=pressure)), EXACT)
    a, b = (np.setdiff1d(mesh.node_sets[lip], mesh.node_sets["CRACK_FRONT"]) for lip in LIPS)
    a, b = (lip[np.lexsort(mesh.points[lip].T)] for lip in (a, b))
    assert (mesh.points[a] == mesh.points[b]).all()
    opening = [(s.displacement[a] - s.displacement[b]) for s in (far, near)]
    assert opening[0][:, 2].min() > 0
    # the uniform field has no opening and is exact in the elements; the solver leaves 1e-12
    assert np.abs(opening[0] - opening[1]).max() <= 1e-9 * size(opening[0])


def test_the_same_model_gives_the_same_bits():
    first, second = (solve(copper(cracked()))[0] for _ in range(2))
    assert first.displacement.tobytes() == second.displacement.tobytes()
    assert first.reactions.tobytes() == second.reactions.tobytes() and first.record == second.record


def test_a_looser_tolerance_is_kept_with_fewer_iterations():
    loose, exact = (solve(copper(cracked()), SolveOptions(tolerance=t))[1] for t in (1e-3, 1e-10))
    assert loose["residual"] <= 1e-3 and exact["residual"] <= 1e-10
    assert 0 < loose["iterations"] < exact["iterations"]


def test_a_body_without_load_stays_where_it_is():
    solution, report = solve(copper(cracked(), magnitude=0.0))
    assert not solution.displacement.any() and report["iterations"] == 0


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (SolveOptions(max_iterations=3), "residual is .* after 3 iterations, expected at most 1e-08"),
        (SolveOptions(tolerance=1e-30), "residual is .*expected at most 1e-30"),
        (SolveOptions(memory_limit=0.01), "memory_limit: .* unknowns need about"),
    ],
)
def test_what_does_not_become_exact_is_refused(options, said):
    with pytest.raises(CraftmeshError, match=said):
        solve(copper(cracked()), options)


def test_a_field_that_is_no_number_is_refused():
    model = copper(block())
    nan = Fixed(model.mesh.node_sets["ZMAX"], 2, float("nan"))
    with pytest.raises(CraftmeshError, match="residual is nan"):
        solve(replace(model, load=replace(model.load, moved=(nan,))))


def test_both_parts_of_a_severed_body_are_held_and_a_stress_that_parts_them_is_refused():
    severed = plane_crack(2, 2, lambda centres: np.ones(len(centres), bool))
    mesh, _ = assemble(*structured_box((3, 3, 4), two_grains, severed))
    for sides, count in (("free", 3 + 3), ("rollers", 0)):
        model = copper(mesh, sides=sides)
        supports_of(model.load, model.mesh)  # raises where a part can move as a whole
        assert sum(len(fixed.nodes) == 1 for fixed in model.load.held) == count
    with pytest.raises(
        CraftmeshError, match="a force of .* along z on the separate piece of .* no support resists it"
    ):
        solve(copper(mesh, load="stress"))


def test_a_piece_that_the_supports_leave_free_is_named():
    severed = plane_crack(2, 2, lambda centres: np.ones(len(centres), bool))
    model = copper(assemble(*structured_box((3, 3, 4), two_grains, severed))[0])
    loose = replace(model, load=replace(model.load, held=model.load.held[:3]))
    with pytest.raises(CraftmeshError, match="a piece of 108 elements .*is not held"):
        solve(loose)


def test_models_without_a_load_with_two_loads_or_turned_elements_are_refused():
    model = copper(block())
    with pytest.raises(CraftmeshError, match="load is none"):
        solve(replace(model, load=None))
    twice = Load(model.load.held, moved=(Fixed(model.mesh.node_sets["ZMIN"], 2, 0.1),))
    with pytest.raises(CraftmeshError, match="node 1 is prescribed to move along z by 0 and by another"):
        solve(replace(model, load=twice))
    points = model.mesh.points.copy()
    points[model.mesh.tets[7, 0]] += 5
    with pytest.raises(CraftmeshError, match="elements are inverted"):
        solve(replace(model, mesh=replace(model.mesh, points=points)))


def test_memory_is_said_to_grow_with_the_mesh():
    small, large = (memory_of(copper(block(shape)).mesh) for shape in ((2, 2, 2), (4, 4, 4)))
    assert 0 < small < large


def test_progress_rises_to_the_end():
    heard = []
    solve(copper(cracked()), progress=lambda fraction, text: heard.append((fraction, text)))
    fractions = [fraction for fraction, _ in heard]
    assert fractions == sorted(fractions) and fractions[-1] > 0.9
    assert "unknowns, about" in heard[0][1] and "residual" in heard[-1][1]

"""The parts of the built-in solver against plain matrices."""

import numpy as np
import pytest
from structured_box import structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.mechanics.model import ElasticModel, elastic_model
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.mechanics.orientation import random_orientations
from craftmesh.mechanics.rigid_body_supports import rigid_motions
from craftmesh.mesh.integration import shape_slopes, tet_rule
from craftmesh.solve.kernels.blocks import negative_upper, solve_lower, solve_upper, subtract_lower
from craftmesh.solve.levels import Aggregates, Corners, StiffnessMatrix, step_of, stiffness_matrix
from craftmesh.solve.problem import Elements, elements_of


def model_of(element: str, shape=(2, 3, 2)) -> ElasticModel:
    mesh = assemble(*structured_box(shape, lambda centres: np.where(centres[:, 0] < 1, 1, 2)))[0]
    options = ModelOptions(element=element, material=("cubic:168.4,121.4,75.4",), quarter_points=False)
    return elastic_model(mesh, options, random_orientations(3, np.random.default_rng(1)))[0]


def parts(element: str, shape=(2, 3, 2)) -> tuple[Elements, np.ndarray, StiffnessMatrix]:
    """Elements with nodes in random order and off the middles, random supports, their matrix."""
    model = model_of(element, shape)
    rng = np.random.default_rng(4)
    number = rng.permutation(len(model.mesh.points))
    points = np.empty_like(model.mesh.points)
    points[number] = model.mesh.points + 0.03 * rng.uniform(-1, 1, points.shape)
    part = np.searchsorted(model.grains, model.mesh.grain)
    elements = Elements(points, number[model.mesh.tets], part, model.stiffness(), 4)
    fixed = rng.random(points.shape) < 0.1
    return elements, fixed, stiffness_matrix(elements, fixed)


def plain_stiffness(elements: Elements) -> np.ndarray:
    """The matrix (3n, 3n) by the definition: sum over points of w (grad N_a) . C . (grad N_b)."""
    pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
    voigt = np.empty((3, 3), int)
    for place, (i, j) in enumerate(pairs):
        voigt[i, j] = voigt[j, i] = place
    places, weights = tet_rule(elements.rule)
    slopes = shape_slopes(places, elements.tets.shape[1])
    total = np.zeros((elements.points.size,) * 2)
    for nodes, part in zip(elements.tets, elements.part):
        c = elements.stiffness[part][voigt[:, :, None, None], voigt[None, None]]
        dofs = (3 * nodes[:, None] + np.arange(3)).ravel()
        for weight, slope in zip(weights, slopes):
            jacobian = elements.points[nodes].T @ slope
            grads = slope @ np.linalg.inv(jacobian)
            own = np.einsum("aj,ijkl,bl->aibk", grads, c, grads) * weight * np.linalg.det(jacobian)
            total[np.ix_(dofs, dofs)] += own.reshape(len(dofs), -1)
    return total


def dense(matrix: StiffnessMatrix) -> np.ndarray:
    return matrix.whole().toarray()


@pytest.mark.parametrize("element", ["C3D4", "C3D10"])
def test_the_matrix_is_that_of_the_definition_with_supports_taken_out(element):
    elements, fixed, matrix = parts(element)
    plain = plain_stiffness(elements)
    held = fixed.ravel()
    taken = np.where(held[:, None] | held, 0.0, plain) + np.diag(np.where(held, plain.diagonal(), 0.0))
    assert np.abs(dense(matrix) - taken).max() <= 1e-13 * plain.max()
    x = np.random.default_rng(0).normal(size=fixed.shape)
    product = np.empty_like(x)
    total = matrix.times(x, product)
    assert np.allclose(product.ravel(), taken @ x.ravel(), atol=1e-12 * plain.max())
    assert total == pytest.approx((x * product).sum())
    assert np.allclose(elements.forces(x).ravel(), plain @ x.ravel(), atol=1e-12 * plain.max())


def test_sweeps_are_the_triangles_solves_and_products():
    _, fixed, matrix = parts("C3D10")
    total, n = dense(matrix), len(fixed)
    blocks = np.arange(3 * n) // 3
    lower, upper = (np.where(sign * (blocks[:, None] - blocks) > 0, total, 0.0) for sign in (1, -1))
    diagonal = total - lower - upper
    b = np.random.default_rng(3).normal(size=(n, 3))
    out, right = np.empty_like(b), b.copy()
    inverse = np.linalg.inv(matrix.diagonal)
    solve_lower(*matrix.triangle, inverse, right, out)
    assert np.allclose((lower + diagonal) @ out.ravel(), b.ravel())
    assert np.allclose(diagonal @ out.ravel(), right.ravel())
    solve_upper(*matrix.triangle, inverse, b, out)
    assert np.allclose((upper + diagonal) @ out.ravel(), b.ravel())
    negative_upper(*matrix.triangle, b, out)
    assert np.allclose(-upper @ b.ravel(), out.ravel())
    subtract_lower(*matrix.triangle, b, out)
    assert np.allclose(-(lower + upper) @ b.ravel(), out.ravel())


@pytest.mark.parametrize("element", ["C3D4", "C3D10"])
def test_a_step_is_symmetric_and_goes_towards_the_answer(element):
    elements, fixed, matrix = parts(element, (4, 5, 4))
    step = step_of(elements, matrix, fixed)
    rng = np.random.default_rng(6)
    a, b, at_a, at_b = np.where(fixed, 0.0, rng.normal(size=(4, *fixed.shape)))
    step(a, at_a)
    step(b, at_b)
    assert (at_a * b).sum() == pytest.approx((at_b * a).sum(), rel=1e-10)
    assert (at_a[fixed] == 0).all()
    answer = np.linalg.solve(dense(matrix), a.ravel()).reshape(a.shape)
    error = answer - at_a
    size = [e.ravel() @ dense(matrix) @ e.ravel() for e in (answer, error)]
    assert size[1] < 0.5 * size[0]  # of the energy; 0.1 was measured


def test_the_corners_answer_carries_rigid_motions():
    elements = elements_of(model_of("C3D10"), 4)
    quarter = elements.points.copy()
    tet = elements.tets[0]
    quarter[tet[4]] = 0.75 * quarter[tet[0]] + 0.25 * quarter[tet[1]]
    elements = Elements(quarter, elements.tets, elements.part, elements.stiffness, 4)
    fixed = np.zeros(quarter.shape, bool)
    fixed[tet[0]] = True
    corners = Corners(elements, fixed)
    motions = rigid_motions(quarter)
    at_corners = motions[corners.corner]
    corners.step = lambda right, out: np.copyto(out, at_corners[:, :, case])
    out = np.empty_like(quarter)
    for case in range(6):
        corners(np.zeros_like(quarter), out)
        assert np.allclose(out, np.where(fixed, 0, motions[:, :, case]), atol=1e-14)


def test_the_way_to_the_corners_is_the_transpose_of_the_way_back():
    elements, fixed, _ = parts("C3D10")
    corners = Corners(elements, fixed)
    rng = np.random.default_rng(8)
    fine, coarse = rng.normal(size=fixed.shape), rng.normal(size=corners.answer.shape)
    heard = {}

    def step(right, out):
        heard["right"] = right.copy()
        np.copyto(out, coarse)

    corners.step = step
    out = np.empty_like(fine)
    corners(fine, out)
    at_fixed = fixed[corners.corner]
    assert (heard["right"][at_fixed] == 0).all()
    free = np.where(at_fixed, 0.0, coarse)
    np.copyto(coarse, free)
    corners(fine, out)
    assert (heard["right"] * free).sum() == pytest.approx((fine * out).sum())


def test_small_and_large_meshes_have_aggregates():
    """Below the coarsest size there is one level, which pyamg solves directly."""
    for shape in ((2, 2, 2), (7, 8, 7)):
        elements, fixed, matrix = parts("C3D4", shape)
        aggregates = Aggregates(elements, matrix, fixed)
        is_small = 3 * len(fixed) <= 300
        assert (aggregates.prolongation.shape[0] == aggregates.prolongation.shape[1]) == is_small
        left = np.where(fixed, 0.0, rigid_motions(elements.points)[:, :, 0])
        out = np.empty_like(left)
        aggregates(left, out)
        if is_small:
            assert np.allclose(dense(matrix) @ out.ravel(), left.ravel())
        assert (out * left).sum() > 0

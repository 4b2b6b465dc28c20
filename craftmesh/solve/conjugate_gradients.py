"""Preconditioned conjugate gradients (Hestenes & Stiefel 1952)."""

from collections.abc import Callable
from typing import Protocol

import numpy as np

from craftmesh.solve.kernels.blocks import add_multiple, dot, renew_direction


class Matrix(Protocol):
    """A symmetric positive definite matrix."""

    def times(self, x: np.ndarray, out: np.ndarray) -> float:
        """Fill `out` with the matrix times x and return x . out."""


def conjugate_gradients(
    matrix: Matrix,
    precondition: Callable[[np.ndarray, np.ndarray], None],
    right: np.ndarray,
    goal: float,
    most: int,
    heard: Callable[[float], None],
) -> tuple[np.ndarray, int]:
    """Return x (n, 3) with |right - matrix x| <= goal, or what `most` iterations gave, and their number.

    precondition(r, out) fills `out` with an approximate answer to r; heard(|r|) is called each iteration.
    The residual is the one that the iteration carries along; rounding parts it from the true one.
    """
    x, residual = np.zeros_like(right), right.copy()
    answer, product = np.empty_like(right), np.empty_like(right)
    direction = np.zeros_like(right)
    before = 1.0
    for iteration in range(most):
        size = np.sqrt(dot(residual, residual))
        heard(size)
        if not size > goal:  # there, or not a number
            return x, iteration
        precondition(residual, answer)
        weight = dot(residual, answer)
        renew_direction(weight / before, answer, direction)
        before = weight
        step = weight / matrix.times(direction, product)
        add_multiple(step, direction, x)
        add_multiple(-step, product, residual)
    return x, most

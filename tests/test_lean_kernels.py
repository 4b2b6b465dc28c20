"""Lean kernels take arrays without counting them and make none; vector kernels divide as numpy does."""

import numpy as np
import pytest
from numba import config
from numba.core.errors import NumbaError

from craftmesh.jit import kernel, lean_kernel, vector_kernel


@lean_kernel
def first_of(values):
    return values[0] if len(values) else 0.0


@kernel
def total_of_copy(values):
    return values.copy().sum()


@lean_kernel
def first_and_total(values):
    return first_of(values) + total_of_copy(values)


@lean_kernel
def total_of_own_copy(values):
    return values.copy().sum()


@lean_kernel
def share(part, whole):
    return part / whole


@vector_kernel
def unchecked_share(part, whole):
    return part / whole


def test_lean_kernels_take_arrays_and_call_what_makes_them():
    assert first_and_total(np.array([2.0, 3.0])) == 7.0


@pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")
def test_lean_kernels_make_no_arrays():
    with pytest.raises(NumbaError, match="NRT required but not enabled"):
        total_of_own_copy(np.ones(2))


@pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")
def test_vector_kernels_divide_by_zero_and_lean_kernels_raise():
    assert unchecked_share(1.0, 0.0) == np.inf and unchecked_share(1.0, 4.0) == share(1.0, 4.0) == 0.25
    with pytest.raises(ZeroDivisionError):
        share(1.0, 0.0)

"""Kernels take in the code of what they call; numba links it as craftmesh.kernel_code expects."""

import numpy as np
import pytest
from numba import config, njit

from craftmesh.jit import kernel, lean_kernel

pytestmark = pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")


@lean_kernel
def share(part, whole):
    return part / whole


@kernel
def sorted_copy(values):
    return np.sort(values)


@kernel
def median_share(values, whole):
    return share(sorted_copy(values)[len(values) // 2], whole)


@njit
def median_share_of_others(values, whole):
    return share(sorted_copy(values)[len(values) // 2], whole)


@njit
def sort_of_others(values):
    return np.sort(values)


VALUES = np.array([3.0, 1.0, 2.0])


@pytest.mark.parametrize("function", [median_share, median_share_of_others, median_share.py_func])
def test_kernels_and_functions_of_others_take_in_their_callees(function):
    assert function(VALUES, 4.0) == 0.5
    with pytest.raises(ZeroDivisionError):
        function(VALUES, 0.0)


def test_callees_can_be_called_by_themselves_and_numbas_functions_by_others():
    assert median_share(VALUES, 4.0) == 0.5
    assert share(1.0, 4.0) == 0.25
    assert sorted_copy(VALUES).tolist() == sort_of_others(VALUES).tolist() == [1.0, 2.0, 3.0]


def test_no_machine_code_is_made_of_a_callee():
    @lean_kernel
    def doubled(x):
        return 2 * x

    @lean_kernel
    def doubled_twice(x):
        return doubled(doubled(x))

    assert doubled_twice(3) == 12
    assert not doubled.signatures and len(doubled_twice.signatures) == 1

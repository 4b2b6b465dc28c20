"""References to arrays for kernels, and whether they work with the numba that is installed."""

import subprocess
import sys
import weakref
from typing import NamedTuple

import numba
import numpy as np
from numba import njit

from craftmesh.gradation.state import Guards, Mesh, Scratch
from craftmesh.kernel_structs import TESTED, by_reference


class Shape(NamedTuple):
    points: np.ndarray
    ids: np.ndarray


class Marks(NamedTuple):
    marks: np.ndarray


@njit
def marked(state, value):
    """Write to one part what is read from the others; the arrays are counted nowhere in here."""
    total = 0.0
    for i in range(len(state.ids)):
        points = state.points
        total += points[state.ids[i]]
        state.marks[i] = value
    return total


def use_references() -> None:
    """Raise AssertionError, or crash, where a reference or the arrays behind it are wrong."""
    for n in range(1, 200):
        shape = Shape(np.arange(n, dtype=float), np.arange(n)[::-1].copy())
        marks = Marks(np.zeros(n, bool))
        held = weakref.ref(shape.points)
        reference = by_reference(shape, marks)
        assert marked(reference, True) == n * (n - 1) / 2
        assert marks.marks.all()
        del shape
        assert held() is not None and marked(reference, False) == n * (n - 1) / 2
        if not numba.config.DISABLE_JIT:
            assert sys.getrefcount(marks.marks) == 2
        del reference
        assert held() is None


def test_references_work_with_this_numba():
    # In a process of its own: where numba has changed what they rest on, it may crash.
    found = subprocess.run([sys.executable, __file__], capture_output=True, text=True, timeout=300)
    assert found.returncode == 0, (
        f"by_reference does not work with numba {numba.__version__}, it does with {', '.join(TESTED)}: "
        f"take one of these, or mend craftmesh/kernel_structs.py.\n{found.stderr[-2000:]}"
    )


def test_a_reference_has_the_fields_of_its_parts():
    shape, marks = Shape(np.zeros(2), np.arange(2)), Marks(np.ones(2, bool))
    reference = by_reference(shape, marks)
    assert reference.ids is shape.ids and reference.marks is marks.marks
    assert not hasattr(reference, "sides")


def test_the_parts_of_a_state_share_no_name():
    names = Mesh._fields + Guards._fields + Scratch._fields
    assert len(set(names)) == len(names)


if __name__ == "__main__":
    use_references()

"""Named tuples of many arrays, handed to kernels by one reference.

A kernel that takes such a tuple by value unpacks, passes and counts every array of it at every call,
which multiplies the time to compile kernels that call kernels and slows them down. Kernels read
`state.points` alike from both. Behind a reference no array is counted at all: the reference keeps the
tuple alive, and kernels keep none of its arrays.
"""

from typing import NamedTuple

from numba import njit, types
from numba.core import cgutils
from numba.core.typing import signature
from numba.experimental import structref
from numba.extending import intrinsic, overload


@structref.register
class ReferenceType(types.StructRef):
    """The numba type of a reference: the names and types of the tuple's fields."""


class Reference(structref.StructRefProxy):
    """What `by_reference` returns: of use to kernels alone, for which it keeps its arrays alive."""

    arrays: NamedTuple


structref.define_boxing(ReferenceType, Reference)


@intrinsic
def _fill(context, reference, arrays):
    def codegen(context, builder, signature_, values):
        for i, (name, kind) in enumerate(zip(arrays.fields, arrays.types)):
            array = context.make_array(kind)(context, builder, builder.extract_value(values[1], i))
            array.meminfo = cgutils.get_null_value(array.meminfo.type)
            put = context.get_setattr(name, signature(types.none, reference, kind))
            put(builder, (values[0], array._getvalue()))
        return context.get_dummy_value()

    return types.none(reference, arrays), codegen


def _referred(arrays):
    raise NotImplementedError("kernels only")


@overload(_referred)
def _compiled_referred(arrays):
    kind = ReferenceType(tuple(zip(arrays.fields, arrays.types)))

    def referred(arrays):
        reference = structref.new(kind)
        _fill(reference, arrays)
        return reference

    return referred


@njit(cache=True)
def _make_reference(arrays):
    return _referred(arrays)


def by_reference(arrays: NamedTuple) -> Reference:
    """Return a reference to the arrays of a named tuple, for kernels; the arrays are shared."""
    reference = _make_reference(arrays)
    reference.arrays = arrays
    return reference

"""Named tuples of many arrays, handed to kernels by one reference.

A kernel that takes such a tuple by value unpacks, passes and counts every array of it at every call,
which multiplies the time to compile kernels that call kernels and slows them down. Behind a reference
kernels read the fields of all its tuples alike, `state.points`, and no array is counted at all: the
reference keeps the tuples alive, and kernels keep none of their arrays.

That the arrays are not counted is done with parts of numba that it does not promise to keep. It works
with the releases TESTED; tests/gradation/test_by_reference.py says so of any other one.
"""

from types import SimpleNamespace
from typing import NamedTuple

from numba import config, types
from numba.core import cgutils
from numba.core.typing import signature
from numba.experimental import structref
from numba.extending import intrinsic, overload

from craftmesh.jit import kernel

TESTED = ("0.68",)


@structref.register
class ReferenceType(types.StructRef):
    """The numba type of a reference: the names and types of the fields."""


class Reference(structref.StructRefProxy):
    """What `by_reference` returns: of use to kernels alone, for which it keeps its arrays alive."""

    parts: tuple[NamedTuple, ...]


structref.define_boxing(ReferenceType, Reference)


@intrinsic
def _fill(context, reference, parts):  # noqa: ARG001
    def codegen(context, builder, signature_, values):  # noqa: ARG001
        for place, name, kind in _fields(parts):
            array = context.make_array(kind)(context, builder, builder.extract_value(values[1], place))
            array.meminfo = cgutils.get_null_value(array.meminfo.type)
            put = context.get_setattr(name, signature(types.none, reference, kind))
            put(builder, (values[0], array._getvalue()))
        return context.get_dummy_value()

    return types.none(reference, parts), codegen


def _fields(parts):
    """Yield the place, name and numba type of each field of the tuples."""
    for i, part in enumerate(parts.types):
        for k, (name, kind) in enumerate(zip(part.fields, part.types)):
            yield (i, k), name, kind


def _referred(parts):
    raise NotImplementedError("kernels only")


@overload(_referred)
def _compiled_referred(parts):
    kind = ReferenceType(tuple((name, kind) for _, name, kind in _fields(parts)))

    def referred(parts):
        reference = structref.new(kind)
        _fill(reference, parts)
        return reference

    return referred


@kernel
def _make_reference(parts):
    return _referred(parts)


def by_reference(*parts: NamedTuple) -> Reference | SimpleNamespace:
    """Return a reference to the arrays of named tuples, for kernels; the arrays are shared.

    No two fields may have one name. Where numba does not compile, what is returned has the same fields.
    """
    if config.DISABLE_JIT:
        return SimpleNamespace(**{name: value for part in parts for name, value in part._asdict().items()})
    reference = _make_reference(parts)
    reference.parts = parts
    return reference

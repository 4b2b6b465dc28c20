"""Named tuples of many arrays, passed to kernels as one reference.

A kernel that takes such a tuple by value unpacks, passes and reference-counts each array at each call.
This multiplies the compile time of kernels that call kernels and slows them down: reference counts took a
fifth of the gradation's time. The reference made here is a bare address without counts. Kernels read the
fields of all its tuples in the same way, `state.points`. Only the Python object keeps the arrays alive, so
kernels must not keep the reference or an array of it after they return.

This depends on numba's internal layout of arrays, which may change. It works with the releases in TESTED;
tests/test_kernel_structs.py fails with an untested release.
"""

from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numba import config, typeof, types
from numba.core.imputils import impl_ret_new_ref
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    NativeValue,
    infer_getattr,
    lower_getattr_generic,
    models,
    register_model,
    typeof_impl,
    unbox,
)

TESTED = ("0.68",)
# Words in numba's array before shape and strides: owner, parent, item count, bytes per item, address.
HEAD = 5


class ReferenceType(types.Type):
    """The numba type of a reference: the names and array types of its fields, in their order in memory."""

    def __init__(self, fields: tuple[tuple[str, types.Array], ...]):
        self.fields = fields
        super().__init__(f"Reference({', '.join(f'{name}: {kind}' for name, kind in fields)})")

    def place(self, wanted: str) -> tuple[int, types.Array]:
        """Return the offset (in words of 8 bytes) and array type of a field; AttributeError if absent."""
        start = 0
        for name, kind in self.fields:
            if name == wanted:
                return start, kind
            start += HEAD + 2 * kind.ndim
        raise AttributeError(wanted)


register_model(ReferenceType)(models.OpaqueModel)


_KINDS: dict[tuple, ReferenceType] = {}


class Reference:
    """The reference that `by_reference` returns; it keeps its arrays alive."""

    def __init__(self, parts: tuple[NamedTuple, ...]):
        self.parts = parts
        fields = [field for part in parts for field in part._asdict().items()]
        self.kind = _kind_of(fields)
        self.words = np.array([word for _, array in fields for word in _words(array)], np.int64)
        self.address = self.words.ctypes.data

    def __getattr__(self, name: str) -> np.ndarray:
        """Return the array of the field `name`."""
        for part in self.__dict__.get("parts", ()):
            if name in part._fields:
                return getattr(part, name)
        raise AttributeError(name)


def _kind_of(fields: list[tuple[str, np.ndarray]]) -> ReferenceType:
    """Return the type of a reference, made once for arrays of the same types."""
    key = tuple((name, array.dtype, array.ndim, array.flags.num) for name, array in fields)
    if key not in _KINDS:
        _KINDS[key] = ReferenceType(tuple((name, typeof(array)) for name, array in fields))
    return _KINDS[key]


def _words(array: np.ndarray) -> tuple[int, ...]:
    """Return numba's array structure as integers; owner and parent are 0, so nothing is counted."""
    return (
        0,
        0,
        array.size,
        array.itemsize,
        array.__array_interface__["data"][0],
        *array.shape,
        *array.strides,
    )


@typeof_impl.register(Reference)
def _typeof(reference, context):  # noqa: ARG001
    return reference.kind


@unbox(ReferenceType)
def _unboxed(kind, reference, c):  # noqa: ARG001
    address = c.pyapi.object_getattr_string(reference, "address")
    pointer = c.pyapi.long_as_voidptr(address)
    c.pyapi.decref(address)
    return NativeValue(pointer, is_error=c.pyapi.c_api_error())


@infer_getattr
class _Fields(AttributeTemplate):
    key = ReferenceType

    def generic_resolve(self, reference, name):
        return dict(reference.fields).get(name)


@lower_getattr_generic(ReferenceType)
def _field(context, builder, reference, value, name):
    start, kind = reference.place(name)
    make = context.make_array(kind)
    words = builder.bitcast(value, context.get_value_type(types.intp).as_pointer())
    there = builder.gep(words, [context.get_constant(types.intp, start)])
    there = builder.bitcast(there, context.get_value_type(kind).as_pointer())
    array = make(context, builder, value=builder.load(there))
    # Numba omits the count of an array only if its owner is null here, not only in memory.
    array.meminfo = context.get_constant_null(types.voidptr)
    array.parent = context.get_constant_null(types.voidptr)
    return impl_ret_new_ref(context, builder, kind, array._getvalue())


def by_reference(*parts: NamedTuple) -> Any:
    """Return a reference to the arrays of named tuples, for kernels; the arrays are shared, not copied.

    The reference has the fields of all tuples. No two fields may have the same name.
    """
    if config.DISABLE_JIT:
        return SimpleNamespace(**{name: value for part in parts for name, value in part._asdict().items()})
    return Reference(parts)

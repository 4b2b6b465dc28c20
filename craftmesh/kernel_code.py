"""Machine code of the kernels that Python calls, made once, with their callees included.

By default numba compiles each callee of a kernel together with the functions that it calls in turn, and
optimises it again in each caller. Here the callees, numba's own functions included, stay in LLVM's
intermediate representation until a kernel that Python calls links them.

This depends on numba's internal linking, which may change; tests/test_kernel_code.py then fails.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from llvmlite.binding import Linkage, parse_assembly
from numba._dynfunc import make_function
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import register_pass
from numba.core.registry import cpu_target
from numba.core.typed_passes import NativeLowering
from numba.extending import overload
from numba.np import arrayobj


class _Code(JITCodeLibrary):
    """A code library that lists all libraries it needs, also the libraries of its callees."""

    def add_linking_library(self, library: Any) -> None:
        super().add_linking_library(library)
        if isinstance(library, _CalleeCode):
            self._linking_libraries += library._linking_libraries

    def _link(self, module: Any) -> None:
        """Link all needed libraries into `module`."""
        for library in dict.fromkeys(self._linking_libraries):
            of_callee = isinstance(library, _CalleeCode)
            own = library.own_module() if of_callee else library._get_module_for_linking()
            module.link_in(own, preserve=True)
            self._reload_init.update(library._reload_init)


class _CalleeCode(_Code):
    """Code of a callee in LLVM's intermediate representation: neither optimised nor compiled."""

    def add_llvm_module(self, ll_module: Any) -> None:
        self._final_module.link_in(ll_module)

    def finalize(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True

    def own_module(self) -> Any:
        return super()._get_module_for_linking()

    def _get_module_for_linking(self) -> Any:
        """Return the code linked with all callees, for functions that numba compiles as usual."""
        module = self.own_module().clone()
        self._link(module)
        return module


class _KernelCode(_Code):
    """Code of a kernel that Python calls, linked with all its callees."""

    def finalize(self) -> None:
        self._link(self._final_module)
        self._linking_libraries.clear()
        super().finalize()

    def serialize_using_object_code(self) -> tuple:
        """Return the cached parts: machine code, and stubs with its names instead of linkable code.

        No function links the code of a kernel that Python calls, so stubs suffice.
        """
        names = [one.name for one in self.get_defined_functions() if one.linkage == Linkage.external]
        stubs = "".join(f'define void @"{name}"() {{ unreachable }}\n' for name in names)
        return self.name, "object", (self._get_compiled_object(), parse_assembly(stubs).as_bitcode())


@register_pass(mutates_CFG=True, analysis_only=False)
class _KernelLowering(NativeLowering):
    """Numba's step from its own representation to LLVM's, into a `_KernelCode`."""

    _name = "kernel_lowering"

    def run_pass(self, state: Any) -> bool:
        state.library = _KernelCode(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return super().run_pass(state)


class KernelCompiler(CompilerBase):
    """Numba's compiler for a kernel that Python calls; it must run within `code_of_callees`."""

    def define_pipelines(self) -> list:
        manager = DefaultPassBuilder.define_nopython_pipeline(self.state)
        manager.passes = [
            (_KernelLowering if one is NativeLowering else one, text) for one, text in manager.passes
        ]
        manager.finalize()
        return [manager]


def _refuse_shapes(source: Any, target: Any) -> None:
    """Replace numba's function for arrays that do not fit the slice they are assigned to."""


@overload(_refuse_shapes)
def _refused_shapes(source, target):  # noqa: ARG001, ANN001, ANN202
    def refuse(source, target):  # noqa: ARG001, ANN001, ANN202
        raise ValueError("cannot assign slice from input of different size")

    return refuse


@contextmanager
def code_of_callees() -> Iterator[None]:
    """Let numba compile functions in this block only to LLVM's intermediate representation (`_CalleeCode`).

    A function that `KernelCompiler` compiles becomes machine code, with its callees. Errors on arrays that
    do not fit a slice omit the shapes, because the code for these was a quarter of a kernel's code.
    """
    context = cpu_target.target_context
    codegen = context.codegen()
    executable, refuse_shapes = context.get_executable, arrayobj.raise_with_shape_context

    def executable_kernel(library: Any, fndesc: Any, env: Any) -> Any:
        if isinstance(library, _CalleeCode):  # a key for numba's tables; nothing calls it
            return make_function(fndesc.lookup_module(), fndesc.qualname, "", 0, env, (library,))
        return executable(library, fndesc, env)

    with global_compiler_lock:
        library_class = codegen._library_class
        codegen._library_class, context.get_executable = _CalleeCode, executable_kernel
        arrayobj.raise_with_shape_context = _refuse_shapes
        try:
            yield
        finally:
            codegen._library_class, context.get_executable = library_class, executable
            arrayobj.raise_with_shape_context = refuse_shapes

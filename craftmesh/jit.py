"""Kernels: numba's njit with a cache that sees changed callees, and without a copy for each constant.

Numba's own cache compares only the source file of the kernel. The machine code includes callees, so after
a change of a callee in another file numba would run old code.

Numba compiles a kernel again for each integer constant that another kernel passes to it. This took a third
of the time to compile the marching cubes. Kernels compiled once for all integers are not slower.

Processes that start together need the same kernels. One compiles a kernel; the others wait and read it from
the cache.

Code in a wheel is used if this CPU can run it, unless the cache on disk has code for exactly this CPU.
"""

import fcntl
import hashlib
import os
import re
import time
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from uuid import uuid4

import numpy as np
from numba import config, njit, types
from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile, InTreeCacheLocator
from numba.core.errors import TypingError
from numba.core.runtime import rtsys

from craftmesh.kernel_code import KernelCompiler, code_of_callees
from craftmesh.wheel_code import FOLDER, usable_target

# Kernels import names from modules, never modules from packages, so this finds all their imports.
IMPORT = re.compile(r"^(?:from|import)\s+(craftmesh(?:\.\w+)+)", re.MULTILINE)
TURN = ".turn"  # suffix of the lock file of the process that compiles a kernel
ENDINGS = (".nbi", ".nbc", TURN)
# Seconds: longer than any kernel takes to compile on a busy machine; then a waiting process compiles too.
LONGEST_WAIT = 120.0
WAIT_STEP = 0.05  # seconds
# Settings of numba that change machine code but are not part of the key of numba's cache.
SETTINGS = (
    *("BOUNDSCHECK", "DEBUGINFO_DEFAULT", "EXTEND_VARIABLE_LIFETIMES", "LLVM_REFPRUNE_FLAGS"),
    *("LLVM_REFPRUNE_PASS", "LOOP_VECTORIZE", "OPT", "SLP_VECTORIZE", "USING_SVML"),
)
# Callees get no entry points for Python and C, because only kernels call them.
NO_WRAPPERS: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def kernel(function: Callable) -> Callable:
    """Return `function` as a kernel: compiled by numba at its first call, or read from the cache on disk.

    The cache folder is NUMBA_CACHE_DIR if set, else `__pycache__` next to the kernel, else the user's
    cache folder. If no folder is writable, each process compiles the kernel again.
    """
    return _compiled(function, _nrt=True)


def lean_kernel(function: Callable) -> Callable:
    """Like `kernel`, but without reference counts, for a function that makes and returns no array.

    Numba otherwise counts references to each array argument at each exit, in memory shared by all threads.
    This took a tenth of the gradation's time and a third of the tetrahedral optimiser's. A function that
    makes an array does not compile ("NRT required but not enabled"); its callees may make arrays.
    """
    return _compiled(function, _nrt=False)


def vector_kernel(function: Callable) -> Callable:
    """Like `lean_kernel`, but a division by zero gives inf or nan instead of an exception.

    The check for zero would prevent the vectorisation of a loop with a division.
    """
    return _compiled(function, _nrt=False, error_model="numpy")


def _compiled(function: Callable, **options: Any) -> Callable:
    # `_nrt` is not documented by numba. It is always given, else a kernel would inherit its caller's value.
    compiled: Any = njit(pipeline_class=KernelCompiler, **options)(function)
    if compiled is not function:  # under NUMBA_DISABLE_JIT, njit returns the function itself
        callee: Any = njit(**NO_WRAPPERS, **options)(function)
        for one in (compiled, callee):
            one._compiler.compile = code_of_callees()(one._compiler.compile)
        compiled.get_call_template = _without_constants(callee.get_call_template)
        compiled.get_overload = callee.get_overload
        with suppress(RuntimeError):
            compiled._cache = _KernelCache(function)
    return compiled


def _without_constants(template: Callable) -> Callable:
    """Return a function that picks a kernel's compilation by argument types, not by values of constants.

    template: numba's function for this, which makes a compilation for each constant in a call. Here it gets
    a constant's type, integer or boolean, except where the kernel then does not compile.
    """

    def plain(kind: types.Type) -> types.Type:
        is_constant = isinstance(kind, types.IntegerLiteral | types.BooleanLiteral)
        return types.unliteral(kind) if is_constant else kind

    def choose(args: tuple, kws: dict) -> Any:
        try:
            return template(tuple(map(plain, args)), {key: plain(kind) for key, kind in kws.items()})
        except TypingError:  # a kernel that uses the constant as a type, or as an index in a mixed tuple
            return template(args, kws)

    return choose


def is_kept(compiled: Any) -> bool:
    """Return whether machine code for a kernel's current sources is on disk; True if it is never cached."""
    kept = getattr(compiled, "_cache", None)
    if not isinstance(kept, _KernelCache):
        return True
    folders = [Path(kept.cache_path), *([FOLDER] if usable_target() else [])]
    return any((folder / f"{kept._impl.filename_base}.nbi").is_file() for folder in folders)


@cache
def code_digest(module: str) -> str:
    """Return a digest of 16 hexadecimal digits for the machine code of a module's kernels.

    The digest covers the sources of `module` and of the craftmesh modules that it imports, numba's
    settings, and numpy's release, on which numba's functions depend. Numba's own cache compares numba's
    release and the CPU.
    """
    numpy = ".".join(np.__version__.split(".")[:2])
    found = {"numpy": numpy} | {name: str(getattr(config, name)) for name in SETTINGS}
    waiting = [module, "craftmesh.kernel_structs"]  # compiles into kernels that need not import it
    while waiting:
        name = waiting.pop()
        if name not in found:
            found[name], imported = _digest_and_imports(name)
            waiting += imported
    text = "\0".join(f"{name}\0{found[name]}" for name in sorted(found))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


@cache
def _digest_and_imports(module: str) -> tuple[str, list[str]]:
    spec = find_spec(module)
    assert spec is not None and spec.origin is not None
    source = Path(spec.origin).read_text(encoding="utf-8")
    return hashlib.sha256(source.encode()).hexdigest(), IMPORT.findall(source)


class _Unwritable(InTreeCacheLocator):
    """The folder of the kernel's source if it is not writable; cache files in it are still read."""

    def ensure_cache_path(self) -> None:
        pass


class _KernelFiles(CompileResultCacheImpl):
    """Names of a kernel's cache files that carry the digest of its sources."""

    _locator_classes = [*CompileResultCacheImpl._locator_classes, _Unwritable]

    def __init__(self, function: Callable):
        super().__init__(function)
        self.stem = self._filename_base
        self._filename_base = f"{self.stem}-{code_digest(function.__module__)}"

    def reduce(self, cres: Any) -> tuple:
        """Return the parts of a compilation to cache, without type annotations, which no process reads."""
        return super().reduce(cres._replace(type_annotation=""))


class _KernelCache(FunctionCache):
    """A cache with separate files for each version of the sources and for each process that writes."""

    _impl_class = _KernelFiles

    def __init__(self, function: Callable):
        super().__init__(function)
        # Two processes may give two signatures the same number; then the index would name the wrong file.
        own = f"{self._impl.filename_base}.{{number:d}}-{uuid4().hex[:8]}.nbc"
        self._cache_file._data_name_pattern = own
        self._turn: int | None = None
        stamp = self._impl.locator.get_source_stamp()
        self._of_wheel = IndexDataCacheFile(str(FOLDER), self._impl.filename_base, stamp)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return a compiled signature, or None if this process has to compile and save it.

        Numba's own method also loads the compiler here, which numba does again before it compiles.
        """
        rtsys.initialize(target_context)
        found = self._load_own(sig, target_context)
        if found is None:
            found = self._load_of_wheel(sig, target_context)
        if found is None and self._turn is None and self._waited_for_turn():
            found = self._load_own(sig, target_context)
        if found is not None:
            self._end_turn()
        return found

    def _load_own(self, sig: Any, target_context: Any) -> Any:
        """Return a signature that a process compiled on this machine, or None."""
        with suppress(OSError):
            return self._load_overload(sig, target_context)
        return None

    def _load_of_wheel(self, sig: Any, target_context: Any) -> Any:
        """Return a signature that the wheel contains for the level of this CPU, or None."""
        target = usable_target()
        if target is None:
            return None
        sig, _, digests = self._index_key(sig, target_context.codegen())
        data = self._of_wheel.load((sig, target, digests))
        return None if data is None else self._impl.rebuild(target_context, data)

    def save_overload(self, sig: Any, data: Any) -> None:
        """Save a compiled signature and remove files of older sources; a full disk is not an error."""
        with suppress(OSError):
            super().save_overload(sig, data)
            for file in self._old_files():
                file.unlink(missing_ok=True)
        self._end_turn()

    def _waited_for_turn(self) -> bool:
        """Lock this kernel for compilation; return True if another process held the lock before.

        The other process may have saved the kernel. A lock ends with its process. After LONGEST_WAIT the
        result is True without a lock. Without a writable folder or file locks, no process waits.
        """
        with suppress(OSError):
            Path(self.cache_path).mkdir(parents=True, exist_ok=True)
            self._turn = os.open(
                Path(self.cache_path) / f"{self._impl.filename_base}{TURN}", os.O_CREAT | os.O_RDWR
            )
            until = time.monotonic() + LONGEST_WAIT
            waited = False
            while time.monotonic() < until:
                with suppress(BlockingIOError):
                    fcntl.flock(self._turn, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    return waited
                waited = True
                time.sleep(WAIT_STEP)
            return waited
        return False

    def _end_turn(self) -> None:
        if self._turn is not None:
            os.close(self._turn)
            self._turn = None

    def _old_files(self) -> list[Path]:
        """Return cache files of this kernel and Python version from older sources, at any line number."""
        name, _, place = self._impl.stem.rpartition("-")
        python = place.partition(".")[2]
        kept = self._impl.filename_base
        found = Path(self.cache_path).glob(f"{name}-*.{python}[-.]*")
        return [file for file in found if file.suffix in ENDINGS and not file.name.startswith(kept)]

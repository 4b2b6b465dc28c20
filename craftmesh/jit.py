"""Kernels: numba's njit, with a cache that sees changes in callees and constants compiled once.

Numba's own cache compares the source of the file that holds a function. A call compiles the callee in,
but a change of the callee, in another file, goes unseen, and old machine code runs on.

Numba compiles a kernel once more for each integer constant that another kernel gives it. That took a third
of the time to compile the marching cubes, and the calls are no slower without.

Processes that start together need the same kernels: one compiles a kernel, the others wait and read it.

Code that lies in a wheel is taken where this CPU can run it, unless the cache has code for this very CPU.
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

# Kernels take names from modules, never modules from packages, so this finds all that they import.
IMPORT = re.compile(r"^(?:from|import)\s+(craftmesh(?:\.\w+)+)", re.MULTILINE)
TURN = ".turn"  # the ending of the file that the process locks which compiles a kernel
ENDINGS = (".nbi", ".nbc", TURN)
# s: longer than any kernel takes to compile on a busy machine; who has waited so long compiles it too
LONGEST_WAIT = 120.0
WAIT_STEP = 0.05  # s
# numba's settings that change machine code; its cache keeps no account of them
SETTINGS = (
    *("BOUNDSCHECK", "DEBUGINFO_DEFAULT", "EXTEND_VARIABLE_LIFETIMES", "LLVM_REFPRUNE_FLAGS"),
    *("LLVM_REFPRUNE_PASS", "LOOP_VECTORIZE", "OPT", "SLP_VECTORIZE", "USING_SVML"),
)
NO_WRAPPERS: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}  # for Python and C


def kernel(function: Callable) -> Callable:
    """Return `function` compiled by numba at its first call, or read from the cache on disk.

    The cache is where numba keeps it: in NUMBA_CACHE_DIR where that is set, else in `__pycache__` beside
    the kernel, else in the user's cache folder. Where none can be written, each process compiles anew.
    """
    return _compiled(function, _nrt=True)


def lean_kernel(function: Callable) -> Callable:
    """Like `kernel`, for a function that makes no array and returns none: it counts no references to them.

    Numba else counts every array that such a function is given, at each of its ends, in memory that all
    threads share: a tenth of the gradation's time, a third of the tetrahedral optimiser's. What makes an
    array does not compile ("NRT required but not enabled"); what it calls may.
    """
    return _compiled(function, _nrt=False)


def vector_kernel(function: Callable) -> Callable:
    """Like `lean_kernel`, with numpy's division: by zero it gives inf or nan, where `lean_kernel` raises.

    That check keeps a loop that divides from being vectorised.
    """
    return _compiled(function, _nrt=False, error_model="numpy")


def _compiled(function: Callable, **options: Any) -> Callable:
    # `_nrt`, which numba does not document, is given for all: else a kernel would do as its caller.
    compiled: Any = njit(pipeline_class=KernelCompiler, **options)(function)
    if compiled is not function:  # as it is under NUMBA_DISABLE_JIT
        callee: Any = njit(**NO_WRAPPERS, **options)(function)
        for one in (compiled, callee):
            one._compiler.compile = code_of_callees()(one._compiler.compile)
        compiled.get_call_template = _without_constants(callee.get_call_template)
        compiled.get_overload = callee.get_overload
        with suppress(RuntimeError):
            compiled._cache = _KernelCache(function)
    return compiled


def _without_constants(template: Callable) -> Callable:
    """Return numba's choice of a kernel's compilation with the types of constants in place of constants."""

    def plain(kind: types.Type) -> types.Type:
        is_constant = isinstance(kind, types.IntegerLiteral | types.BooleanLiteral)
        return types.unliteral(kind) if is_constant else kind

    def choose(args: tuple, kws: dict) -> Any:
        try:
            return template(tuple(map(plain, args)), {key: plain(kind) for key, kind in kws.items()})
        except TypingError:  # a kernel that takes the constant for a type or for a place in a mixed tuple
            return template(args, kws)

    return choose


def is_kept(compiled: Any) -> bool:
    """Return whether machine code of a kernel's present sources is on disk, or never is."""
    kept = getattr(compiled, "_cache", None)
    if not isinstance(kept, _KernelCache):
        return True
    folders = [Path(kept.cache_path), *([FOLDER] if usable_target() else [])]
    return any((folder / f"{kept._impl.filename_base}.nbi").is_file() for folder in folders)


@cache
def code_digest(module: str) -> str:
    """Return 16 hexadecimal digits for all that decides the machine code of a module's kernels.

    These are the sources of `module` and of the craftmesh modules it imports, numba's settings, and numpy's
    release, to which numba fits its functions. Numba's cache itself compares numba's release and the CPU.
    """
    numpy = ".".join(np.__version__.split(".")[:2])
    found = {"numpy": numpy} | {name: str(getattr(config, name)) for name in SETTINGS}
    waiting = [module, "craftmesh.by_reference"]  # which lowers code of kernels that need not import it
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
    """The folder beside the kernel, where nobody can write: what lies there is read all the same."""

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
        """Return what the cache keeps of a compilation: no types of its lines, which no process reads."""
        return super().reduce(cres._replace(type_annotation=""))


class _KernelCache(FunctionCache):
    """A cache whose files no two versions of the code share, nor two processes that write at once."""

    _impl_class = _KernelFiles

    def __init__(self, function: Callable):
        super().__init__(function)
        # Two processes number the data of two signatures alike, and the index would name the wrong one.
        own = f"{self._impl.filename_base}.{{number:d}}-{uuid4().hex[:8]}.nbc"
        self._cache_file._data_name_pattern = own
        self._turn: int | None = None
        stamp = self._impl.locator.get_source_stamp()
        self._of_wheel = IndexDataCacheFile(str(FOLDER), self._impl.filename_base, stamp)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return a compiled signature, or None when it is this process' turn to compile and to save it.

        Numba would load here all that it needs to compile, which it does again where it compiles.
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
        """Return a signature that a process has compiled on this machine, or None."""
        with suppress(OSError):
            return self._load_overload(sig, target_context)
        return None

    def _load_of_wheel(self, sig: Any, target_context: Any) -> Any:
        """Return a signature that the wheel has compiled for the level of this CPU, or None."""
        target = usable_target()
        if target is None:
            return None
        sig, _, digests = self._index_key(sig, target_context.codegen())
        data = self._of_wheel.load((sig, target, digests))
        return None if data is None else self._impl.rebuild(target_context, data)

    def save_overload(self, sig: Any, data: Any) -> None:
        """Save a compiled signature and remove the files of older sources; a full disk is no error."""
        with suppress(OSError):
            super().save_overload(sig, data)
            for file in self._old_files():
                file.unlink(missing_ok=True)
        self._end_turn()

    def _waited_for_turn(self) -> bool:
        """Take this kernel's turn among processes; True if another had it, who may have saved it.

        A turn ends with its process; where none can be had (no folder, no locks on its file system) nobody
        waits.
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
        """Return this kernel's files of the same Python that older sources left, at whatever line."""
        name, _, place = self._impl.stem.rpartition("-")
        python = place.partition(".")[2]
        kept = self._impl.filename_base
        found = Path(self.cache_path).glob(f"{name}-*.{python}[-.]*")
        return [file for file in found if file.suffix in ENDINGS and not file.name.startswith(kept)]

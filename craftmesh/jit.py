"""`kernel`: numba's njit with a cache that sees changes in callees, and one compilation for all constants.

Numba's own cache compares the source of the file that holds a function. A call compiles the callee in,
but a change of the callee, in another file, goes unseen, and old machine code runs on.

Numba compiles a kernel once more for each integer constant that another kernel gives it. That took a third
of the time to compile the marching cubes, and the calls are no slower without.
"""

import hashlib
import re
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from uuid import uuid4

from numba import njit, types
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.errors import TypingError

# Kernels take names from modules, never modules from packages, so this finds all that they import.
IMPORT = re.compile(r"^(?:from|import)\s+(craftmesh(?:\.\w+)+)", re.MULTILINE)


def kernel(function: Callable) -> Callable:
    """Return `function` compiled by numba at its first call, or read from the cache on disk.

    The cache is where numba keeps it: in NUMBA_CACHE_DIR where that is set, else in `__pycache__` beside
    the kernel, else in the user's cache folder. Where none can be written, each process compiles anew.
    """
    compiled: Any = njit(function)
    if compiled is not function:  # as it is under NUMBA_DISABLE_JIT
        compiled.get_call_template = _without_constants(compiled.get_call_template)
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


@cache
def sources_digest(module: str) -> str:
    """Return 16 hexadecimal digits for the sources of `module` and of all craftmesh modules it imports."""
    found: dict[str, str] = {}
    waiting = [module]
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


class _KernelFiles(CompileResultCacheImpl):
    """Names of a kernel's cache files that carry the digest of its sources."""

    def __init__(self, function: Callable):
        super().__init__(function)
        self.stem = self._filename_base
        self._filename_base = f"{self.stem}-{sources_digest(function.__module__)}"


class _KernelCache(FunctionCache):
    """A cache whose files no two versions of the code share, nor two processes that write at once."""

    _impl_class = _KernelFiles

    def __init__(self, function: Callable):
        super().__init__(function)
        # Two processes number the data of two signatures alike, and the index would name the wrong one.
        own = f"{self._impl.filename_base}.{{number:d}}-{uuid4().hex[:8]}.nbc"
        self._cache_file._data_name_pattern = own

    def save_overload(self, sig: Any, data: Any) -> None:
        """Save a compiled signature and remove the files of older sources; a full disk is no error."""
        with suppress(OSError):
            super().save_overload(sig, data)
            for file in self._old_files():
                file.unlink(missing_ok=True)

    def _old_files(self) -> list[Path]:
        """Return this kernel's files of the same Python that older sources left, at whatever line."""
        name, _, place = self._impl.stem.rpartition("-")
        python = place.partition(".")[2]
        files = Path(self.cache_path).glob(f"{name}-*.{python}[-.]*.nb[ic]")
        return [file for file in files if not file.name.startswith(self._impl.filename_base)]

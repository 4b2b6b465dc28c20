"""Machine code of kernels that a wheel brings (.ci/wheel makes it), for every CPU of a level.

The files are those of the cache on disk (craftmesh.jit). Their names carry the digest of a kernel's
sources: a kernel that was changed, or that calls one that was, finds none.
"""

from functools import cache
from pathlib import Path

from llvmlite.binding import get_process_triple
from numba import config
from numba.core.codegen import get_host_cpu_features

FOLDER = Path(__file__).with_name("machine_code")
# LLVM's names of the level and of its features, per platform; Intel's CPUs have it since 2013, AMD's 2015
LEVELS = {
    "x86_64-unknown-linux-gnu": (
        "x86-64-v3",
        "+64bit,+avx,+avx2,+bmi,+bmi2,+cmov,+cx16,+cx8,+f16c,+fma,+fxsr,+lzcnt,+mmx,+movbe,+popcnt,+sahf,"
        "+sse,+sse2,+sse3,+sse4.1,+sse4.2,+ssse3,+xsave",
    )
}


@cache
def usable_target() -> tuple[str, str, str] | None:
    """Return platform, CPU and features of the code in FOLDER; None if there is none, or none for this CPU.

    Code for another CPU, which NUMBA_CPU_NAME may name, is not there either.
    """
    platform = get_process_triple()
    asked_for: str | None = config.CPU_NAME  # type: ignore[attr-defined]
    if platform not in LEVELS or asked_for or not FOLDER.is_dir():
        return None
    name, features = LEVELS[platform]
    has_all = set(features.split(",")) <= set(get_host_cpu_features().split(","))
    return (platform, name, features) if has_all else None

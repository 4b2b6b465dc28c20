"""Machine code of kernels in a wheel (made by .ci/wheel), for every CPU of a level.

The files have the format of the cache on disk (craftmesh.jit). Their names contain the digest of a kernel's
sources, so a kernel that has changed, or whose callee has changed, does not use them.
"""

from functools import cache
from pathlib import Path

from llvmlite.binding import get_process_triple
from numba import config
from numba.core.codegen import get_host_cpu_features

FOLDER = Path(__file__).with_name("machine_code")
# LLVM's names of the level and its features, by platform; Intel CPUs have it since 2013, AMD since 2015.
LEVELS = {
    "x86_64-unknown-linux-gnu": (
        "x86-64-v3",
        "+64bit,+avx,+avx2,+bmi,+bmi2,+cmov,+cx16,+cx8,+f16c,+fma,+fxsr,+lzcnt,+mmx,+movbe,+popcnt,+sahf,"
        "+sse,+sse2,+sse3,+sse4.1,+sse4.2,+ssse3,+xsave",
    )
}


@cache
def usable_target() -> tuple[str, str, str] | None:
    """Return (platform, CPU level, features) of the code in FOLDER, or None if it is not usable.

    The code is usable if FOLDER exists, this CPU has all features and NUMBA_CPU_NAME names no other CPU.
    """
    platform = get_process_triple()
    asked_for: str | None = config.CPU_NAME  # type: ignore[attr-defined]
    if platform not in LEVELS or asked_for or not FOLDER.is_dir():
        return None
    name, features = LEVELS[platform]
    has_all = set(features.split(",")) <= set(get_host_cpu_features().split(","))
    return (platform, name, features) if has_all else None

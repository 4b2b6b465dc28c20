"""Measuring in processes of their own: CPU seconds, peak memory, tables and the flags of all benchmarks."""

import argparse
import json
import math
import multiprocessing
import os
import pickle
import resource
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from typing import Any

SPAWN = multiprocessing.get_context("spawn")


class ChildFailed(Exception):
    """A measured process raised an error or was ended by a signal."""


def in_child(function: Callable, *arguments: Any) -> Any:
    """Return function(*arguments) from a fresh Python process; raises ChildFailed when it has no answer."""
    receiver, sender = SPAWN.Pipe(duplex=False)
    process = SPAWN.Process(target=_answer, args=(sender, function, arguments))
    process.start()
    sender.close()
    try:
        sound, value = receiver.recv()
    except EOFError:
        process.join()
        raise ChildFailed(f"the process ended with code {process.exitcode}") from None
    process.join()
    if not sound:
        raise ChildFailed(value)
    return value


def _answer(sender, function: Callable, arguments: tuple) -> None:
    try:
        answer = True, function(*arguments)
    except Exception as error:
        answer = False, f"{type(error).__name__}: {error}"
    sender.send(answer)
    sender.close()


def timed(function: Callable, *arguments: Any) -> tuple[Any, dict]:
    """Return the function's value, and its CPU seconds and the process's peak memory so far (MB).

    Both count worker processes that have ended: their seconds, and the largest one's memory.
    """
    before = cpu_seconds()
    value = function(*arguments)
    return value, {"cpu_s": cpu_seconds() - before, "peak_mb": peak_megabytes()}


def cpu_seconds() -> float:
    """Return user and system seconds of this process and of its children that have ended."""
    return sum(usage.ru_utime + usage.ru_stime for usage in _usages())


def peak_megabytes() -> float:
    """Return the largest resident memory of this process and of its largest child together."""
    return sum(usage.ru_maxrss for usage in _usages()) / 1024


def _usages() -> list:
    return [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]


def repeated(runs: int, function: Callable, *arguments: Any) -> dict:
    """Return the figures of `runs` processes: median CPU seconds, largest peak, the others from the last.

    function(*arguments) returns a dict with at least cpu_s and peak_mb. A process that fails gives a
    dict whose only key is `failed`.
    """
    try:
        figures = [in_child(function, *arguments) for _ in range(runs)]
    except ChildFailed as error:
        return {"failed": str(error)}
    cpu, peak = ([one[key] for one in figures] for key in ("cpu_s", "peak_mb"))
    return figures[-1] | {"cpu_s": median(cpu), "peak_mb": max(peak)}


def side_by_side(
    cases: Mapping[str, Any], prepare: Callable, methods: Mapping[str, tuple], folder: str, runs: int
) -> Iterator[dict]:
    """Yield a row per case and method, printing the cases that are skipped for a missing file.

    prepare(case, path) writes a case's input; a method is a function of that path and its other arguments.
    """
    for name, case in cases.items():
        if case.missing:
            print(f"{name}: skipped, {case.missing}")
            continue
        path = f"{folder}/{name}"
        in_child(prepare, case, path)
        for method, (function, *arguments) in methods.items():
            print(f"{name}, {method} ...", file=sys.stderr)
            yield {"case": name, "method": method} | repeated(runs, function, path, *arguments)


def compilation(function: Callable, *arguments: Any) -> dict:
    """Return and print the CPU seconds of function(*arguments), kernels compiled and from the cache."""
    with _empty_jit_cache():
        cold = in_child(function, *arguments)["cpu_s"]
    in_child(function, *arguments)  # compiles what the cache lacks
    warm = in_child(function, *arguments)["cpu_s"]
    print(f"kernels on a tiny case: {cold:.1f} CPU s to compile, {warm:.1f} from the cache")
    return {"cold_s": cold, "cached_s": warm}


@contextmanager
def _empty_jit_cache() -> Iterator[None]:
    """Let processes started meanwhile compile all numba kernels anew."""
    before = os.environ.get("NUMBA_CACHE_DIR")
    with tempfile.TemporaryDirectory() as folder:
        os.environ["NUMBA_CACHE_DIR"] = folder
        try:
            yield
        finally:
            del os.environ["NUMBA_CACHE_DIR"]
            if before is not None:
                os.environ["NUMBA_CACHE_DIR"] = before


def save(path: str, value: Any) -> None:
    """Write a value for another process."""
    Path(path).write_bytes(pickle.dumps(value))


def load(path: str) -> Any:
    """Read what `save` wrote."""
    return pickle.loads(Path(path).read_bytes())


def flags(description: str, cases: Sequence[str]) -> argparse.ArgumentParser:
    """Return a parser with the flags that every benchmark has."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument(
        "--case", action="append", choices=cases, help="only this case; may be given several times"
    )
    parser.add_argument("--runs", type=int, default=3, metavar="N", help="runs per figure (default 3)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures to this file")
    parser.add_argument("--no-peers", action="store_true", help="leave mmg out")
    parser.add_argument(
        "--cold", action="store_true", help="measure the compilation of the kernels too, on a tiny case"
    )
    return parser


def print_table(rows: Iterable[dict], columns: dict[str, str]) -> None:
    """Print rows under the headings `columns` (key -> heading), numbers with four digits."""
    lines = [list(columns.values())]
    for row in rows:
        if "failed" in row:
            lines.append([row["case"], row["method"], "failed: " + row["failed"]])
        else:
            lines.append([_text(row.get(key)) for key in columns])
    widths = [max(len(line[i]) for line in lines if len(line) == len(columns)) for i in range(len(columns))]
    for line in lines:
        print("  ".join(text.ljust(width) for text, width in zip(line, widths)).rstrip())


def _text(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, float):
        small = value and math.isfinite(value) and abs(value) < 1000
        return f"{value:.4g}" if small else f"{value:.0f}"
    if isinstance(value, (list, tuple)):
        return "/".join(_text(v) for v in value) or "-"
    return str(value)


def write_json(path: Path | None, content: dict) -> None:
    """Write the figures where a path is given."""
    if path is not None:
        path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")

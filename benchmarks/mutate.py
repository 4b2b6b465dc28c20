"""Random one-character faults in rooms of the package: which of them the tests see, and which live.

A fault puts one operator, digit, truth value, `and` or `or` in the place of another. Docstrings, strings,
annotations and imports stay. It is made in a copy of the project, where the room's tests run, those that
import its module first. With `--wide`, what lives faces the tests elsewhere that import from the room.
"""

import argparse
import ast
import io
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import tokenize
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

from measure import cpu_seconds

ROOT = Path(__file__).resolve().parents[1]
LEFT_OUT = (".git", ".venv", ".snakemake", ".*cache", ".hypothesis", "results", "site")
SWAPS = {
    **{"+": "-", "-": "+", "*": "/", "/": "*", "//": "%", "%": "*", "**": "*", "&": "|", "|": "&"},
    **{"<": ">", ">": "<", "<=": ">=", ">=": "<=", "==": "!=", "!=": "=="},
    **{"+=": "-=", "-=": "+=", "*=": "/=", "/=": "*=", "&=": "|=", "|=": "&="},
    **{"and": "or", "or": "and", "True": "False", "False": "True"},
}
LONGEST = 3600.0  # CPU s that the tests of a room may take without a fault
SPARE = 120.0  # CPU s: what tests may take over three times that with one, for kernels are compiled anew


@dataclass(frozen=True)
class Fault:
    """A module of the project, the number of the line that is wrong in it, and the wrong line."""

    module: Path
    text: str = field(repr=False)
    line: int
    wrong: str

    @property
    def source(self) -> str:
        lines = self.text.splitlines(keepends=True)
        return "".join([*lines[: self.line - 1], self.wrong, *lines[self.line :]])

    def __str__(self) -> str:
        right = self.text.splitlines()[self.line - 1].strip()
        return f"{self.module}:{self.line}\n    - {right}\n    + {self.wrong.strip()}"


def main() -> None:
    flags = argparse.ArgumentParser(description=__doc__)
    flags.add_argument("rooms", nargs="+", metavar="ROOM", help="rooms of craftmesh, as growth or deck")
    flags.add_argument(
        "--count", type=int, default=10, metavar="N", help="faults in each room; 10 if left out"
    )
    flags.add_argument(
        "--seed", type=int, default=0, help="which faults; one Python version draws the same"
    )
    flags.add_argument("--wide", action="store_true", help="ask the tests of other rooms about what lives")
    flags.add_argument("--list", action="store_true", help="print the faults and run no test")
    arguments = flags.parse_args()
    outcomes: Counter[str] = Counter()
    for room in arguments.rooms:
        faults = list(islice(drawn_faults(ROOT, room, arguments.seed), arguments.count))
        found = ("" for _ in faults) if arguments.list else tried(room, faults, arguments.wide)
        for fault, outcome in zip(faults, found):
            outcomes[outcome] += 1
            print(outcome, fault, flush=True)
    if not arguments.list:
        killed, count = outcomes.total() - outcomes["lives"], outcomes.total()
        print(f"{killed} of {count} killed ({100 * killed / max(count, 1):.0f} %)")


def drawn_faults(root: Path, room: str, seed: int) -> Iterator[Fault]:
    """Yield faults at all places of a room, in a random order."""
    rng = random.Random(f"{seed} {room}")
    places = [
        (path.relative_to(root), text, token)
        for path in sorted((root / "craftmesh" / room).rglob("*.py"))
        for text in [path.read_text(encoding="utf-8")]
        for token in changeable(text)
    ]
    rng.shuffle(places)
    for module, text, token in places:
        wrong = token.line[: token.start[1]] + changed(token.string, rng) + token.line[token.end[1] :]
        fault = Fault(module, text, token.start[0], wrong)
        with suppress(SyntaxError):
            if bare_tree(fault.source) != bare_tree(text):
                yield fault


def changeable(text: str) -> Iterator[tokenize.TokenInfo]:
    """Yield the tokens of a source that a fault may change, but not stars of arguments."""
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        is_star = token.string in ("*", "/") and token.line[token.end[1] :].startswith(",")
        if not is_star and (token.string in SWAPS or token.type == tokenize.NUMBER):
            yield token


def changed(token: str, rng: random.Random) -> str:
    """Return another operator or word in the place of one, or a number with one digit changed."""
    if token in SWAPS:
        return SWAPS[token]
    place = rng.choice([k for k, letter in enumerate(token) if letter.isdigit()])
    digit = rng.choice([digit for digit in "0123456789" if digit != token[place]])
    return token[:place] + digit + token[place + 1 :]


def bare_tree(text: str) -> str:
    """Return the syntax tree of a source without annotations, imports and strings."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        for name, value in ast.iter_fields(node):
            if name in ("annotation", "returns") or isinstance(value, ast.JoinedStr):
                setattr(node, name, None)
            elif isinstance(value, list):
                left_out = (ast.Import, ast.ImportFrom, ast.JoinedStr)
                value[:] = [part for part in value if not isinstance(part, left_out)]
            elif isinstance(node, ast.Constant) and isinstance(value, str):
                node.value = ""
    return ast.dump(tree)


def tried(room: str, faults: Sequence[Fault], is_wide: bool) -> Iterator[str]:
    """Yield what becomes of each fault: killed by a test, hung, or lives."""
    with tempfile.TemporaryDirectory() as scratch:
        sound, copy = Path(scratch) / "sound", Path(scratch) / "copy"
        shutil.copytree(ROOT, sound, ignore=shutil.ignore_patterns(*LEFT_OUT))
        if (ROOT.parent / "shared").is_dir():
            (Path(scratch) / "shared").symlink_to(ROOT.parent / "shared")
        before = cpu_seconds()
        if outcome_of(sound, [f"tests/{room}"], LONGEST) != "lives":
            raise SystemExit(f"tests/{room} fails without a fault; mend it first")
        limit = SPARE + 3 * (cpu_seconds() - before)
        for fault in faults:
            shutil.rmtree(copy, ignore_errors=True)
            shutil.copytree(sound, copy)
            module = copy / fault.module
            module.write_text(fault.source, encoding="utf-8")
            for stale in module.parent.glob(f"__pycache__/{module.stem}.*.pyc"):
                stale.unlink()  # Python tells sources apart by whole seconds and sizes
            own, elsewhere = tests_of(room, fault.module)
            outcome = outcome_of(copy, own, limit)
            if outcome == "lives" and is_wide and elsewhere:
                outcome = outcome_of(copy, elsewhere, 10 * limit).replace("killed", "killed elsewhere")
            yield outcome


def tests_of(room: str, module: Path) -> tuple[list[str], list[str]]:
    """Return a room's tests, and those elsewhere that import from it but campaigns; the module's first."""
    own, elsewhere = [], []
    name = ".".join(module.with_suffix("").parts)
    for file in sorted((ROOT / "tests").rglob("test_*.py")):
        imported = re.findall(
            r"^\s*(?:from|import) (craftmesh[\w.]*)", file.read_text(encoding="utf-8"), re.M
        )
        row = name not in imported, str(file.relative_to(ROOT))
        if file.parent.name == room:
            own.append(row)
        elif file.parent.name != "workflow" and any(
            one.startswith(f"craftmesh.{room}.") for one in imported
        ):
            elsewhere.append(row)
    return [file for _, file in sorted(own)], [file for _, file in sorted(elsewhere)]


def outcome_of(project: Path, tests: Sequence[str], limit: float) -> str:
    """Return what tests of a copy of the project say: killed or lives; hung after `limit` CPU seconds."""
    process = subprocess.Popen(
        [sys.executable, "-m", "pytest", "-x", "-m", "not slow", "-p", "no:cacheprovider", *tests],
        cwd=project,
        env=os.environ | {"PYTHONPATH": str(project)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    resource.prlimit(process.pid, resource.RLIMIT_CPU, (int(limit), int(limit) + 1))
    try:
        code = process.wait(10 * limit)
    except subprocess.TimeoutExpired:
        code = -signal.SIGKILL
    if code in (-signal.SIGXCPU, -signal.SIGKILL):
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        return "hung"
    return "killed" if code else "lives"


if __name__ == "__main__":
    main()

"""One seed in a process of its own, under limits of time and memory: drawn, meshed, checked, judged."""

import hashlib
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from cases import DATA

JUDGE = DATA.parent / "judge" / "judge_inp.py"
SCRIPT = Path(__file__).resolve().parents[1] / "random_cracks.py"
TIME_LIMIT = 400.0  # s; a case takes 5 to 60
MEMORY_LIMIT = 10.0  # GB of address space; the libraries alone take 4


class Trial(NamedTuple):
    """What is done with a seed: judged, files kept where, one kind of crack alone."""

    judged: bool = False
    keep: Path | None = None
    kind: str | None = None

    @property
    def flags(self) -> list[str]:
        """The flags of random_cracks.py that say the same."""
        given = {"--keep": self.keep, "--kind": self.kind}
        flags = [word for flag, value in given.items() if value for word in (flag, str(value))]
        return flags + (["--judge"] if self.judged else [])


def run_apart(seed: int, trial: Trial, time_limit: float) -> dict:
    """Return the row of a seed, made by a process of its own; a crash or a hang is a row too."""
    return script_apart(SCRIPT, seed, trial.flags, time_limit, trial.keep is not None)


def script_apart(script: Path, seed: int, flags: list[str], time_limit: float, loud: bool = False) -> dict:
    """Return the row that `script SEED SEED --inside FILE` writes, run by a process of its own."""
    with tempfile.TemporaryDirectory() as scratch:
        target = Path(scratch) / "row.json"
        command = [sys.executable, str(script), str(seed), str(seed), "--inside", str(target), *flags]
        started = time.monotonic()
        environment = os.environ | {"TMPDIR": scratch}
        process = subprocess.Popen(
            command,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            output, _ = process.communicate(timeout=time_limit)
            end = f"ended with code {process.returncode}"
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            output, _ = process.communicate()
            end = f"no end within {time_limit:g} s"
        if loud:
            print(output.decode(errors="replace"))
        row = json.loads(target.read_text()) if target.exists() else {"seed": seed}
        if "outcome" not in row:
            last = output.decode(errors="replace").strip().splitlines()[-3:]
            row |= {"outcome": "crash", "message": " | ".join([end, *last]), "faults": {"crash": end}}
        return row | {"seconds": round(time.monotonic() - started, 1), "commit": commit()}


def commit() -> str | None:
    """Return the short name of the checkout's commit; None without git."""
    words = ["git", "-C", str(SCRIPT.parent), "rev-parse", "--short", "HEAD"]
    try:
        return subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return None


def run_inside(seed: int, target: Path, trial: Trial) -> None:
    """Draw, mesh and check one seed in this process; write its row to `target`, what is drawn first."""
    soft = int(MEMORY_LIMIT * 1e9)
    resource.setrlimit(resource.RLIMIT_AS, (soft, resource.getrlimit(resource.RLIMIT_AS)[1]))
    from trials.chain import run_chain, write_inputs
    from trials.drawing import draw

    case = draw(seed, kind=trial.kind)
    row: dict = {"seed": seed, "words": case.words, **case.kinds, "l_min": case.sizes.l_min}
    row["sizes"] = [getattr(case.sizes, key) for key in ("l_min", "l0", "l_max", "r0", "r1", "gradation")]
    target.write_text(json.dumps(row))
    if trial.keep is not None:
        print("\n".join(write_inputs(case, trial.keep)), flush=True)
    with tempfile.TemporaryDirectory() as scratch:
        made = run_chain(case, trial.keep or Path(scratch))
        row |= checked(case, made)
        if made.deck is not None and trial.judged:
            row |= judge(made.deck)
    from trials.verdict import faults_of

    row["faults"] = faults_of(row)
    row["cpu_s"] = cpu_seconds()
    target.write_text(json.dumps(row))


def cpu_seconds() -> float:
    """Return the CPU time of this process and of those that it has waited for."""
    return round(sum(sum(resource.getrusage(who)[:2]) for who in (0, -1)), 1)


def checked(case, made) -> dict:
    """Return what came of the chain, and every check's figures where that is a deck."""
    from trials.crack_checks import check_crack, check_inserted, may_be_refused
    from trials.deck_file import read_deck
    from trials.tet_checks import check_sizes, check_tets
    from trials.wedges import check_wedges

    l_min = float(case.sizes.l_min)
    row = {"may_be_refused": may_be_refused(case, l_min), "warnings": list(made.warnings)}
    if made.refusal is not None:
        return row | {"outcome": "refusal", "stage": made.stage, "message": made.refusal}
    deck = read_deck(made.deck)
    return row | {
        "outcome": "deck",
        "deck": hashlib.sha256(made.deck.read_bytes()).hexdigest()[:10],
        **check_crack(case, deck, l_min),
        **check_inserted(case, made.inserted, l_min),
        **check_wedges(made.inserted, made.gradated, made.sizing),
        **check_tets(case, deck, made.inserted, made.gradated, made.sizing),
        **check_sizes(made.gradated, made.sizing),
    }


def judge(deck: Path) -> dict:
    """Return the faults that the external judge finds in a deck."""
    done = subprocess.run([sys.executable, str(JUDGE), str(deck)], capture_output=True, text=True)
    try:
        return {"judged": json.loads(done.stdout)["faults"]}
    except ValueError:
        return {"judged": [f"the judge failed: {done.stderr.strip()[-200:]}"]}

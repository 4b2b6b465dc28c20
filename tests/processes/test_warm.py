"""Verbs that a server runs say and write what they do alone, and end with who asked for them."""

import csv
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest
from snakemake.benchmark import BenchmarkRecord

from craftmesh.processes import costs, warm

CRAFTMESH = str(Path(sys.executable).with_name("craftmesh"))
SMALL = ("generate", "--shape", "9", "8", "7", "--grains", "2")
MISSING = ("size", "none.vtp", "-o", "x.npz")
LONG = ("generate", "--shape", "200", "200", "200", "--grains", "400")
# an owner that starts a server, tells its number and name, and stays
OWNER = """
import os, sys, psutil
from craftmesh.processes.warm import VARIABLE, start
start()
print(psutil.Process().children()[0].pid, os.environ[VARIABLE], flush=True)
sys.stdin.read()
"""


@pytest.fixture
def owner():
    """Start an owner of a server; yields its process, the server's, and the environment of verbs."""
    command = [sys.executable, "-c", OWNER]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        pid, name = process.stdout.readline().split()
        yield process, psutil.Process(int(pid)), os.environ | {warm.VARIABLE: name}
        process.kill()


def started(folder: Path, words, env) -> subprocess.Popen:
    return subprocess.Popen(
        [CRAFTMESH, *words],
        cwd=folder,
        env=env,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        stdin=subprocess.DEVNULL,
        text=True,
    )


def ended(folder: Path, words, env) -> tuple[int, str, str]:
    process = started(folder, words, env)
    return (*process.communicate(timeout=300), process.returncode)


def wait_for(is_reached, seconds: float = 60):
    until = time.monotonic() + seconds
    while not is_reached():
        assert time.monotonic() < until
        time.sleep(0.02)


def test_files_words_and_statuses_are_those_of_a_verb_alone(owner, tmp_path):
    _, server, env = owner
    commands = [
        (*SMALL, "-o", "made.npz"),
        ("size", "none.vtp", "-o", "x.npz"),
        ("size", "--wrong"),
        ("nothing",),
    ]
    made = {}
    for name, environment in (("alone", os.environ), ("first", env), ("second", env)):
        folder = tmp_path / name
        folder.mkdir()
        said = [ended(folder, words, environment) for words in commands]
        made[name] = said, {path.name: path.read_bytes() for path in folder.iterdir()}
    assert made["first"] == made["second"] == made["alone"]
    assert [status for _, _, status in made["alone"][0]] == [0, 1, 1, 1]
    assert server.is_running() and server.children() == []


def test_a_killed_verb_ends_its_child_and_a_killed_child_its_verb(owner, tmp_path):
    _, server, env = owner
    for ends_child in (False, True):
        process = started(tmp_path, (*LONG, "-o", "made.npz"), env)
        wait_for(server.children)
        (child,) = server.children()
        os.kill(child.pid if ends_child else process.pid, signal.SIGKILL)
        process.communicate(timeout=60)
        assert process.returncode == (128 + signal.SIGKILL if ends_child else -signal.SIGKILL)
        wait_for(lambda: not server.children())
    assert not (tmp_path / "made.npz").exists()
    assert ended(tmp_path, (*SMALL, "-o", "made.npz"), env)[-1] == 0


def test_the_server_ends_with_its_owner_and_verbs_then_run_alone(owner, tmp_path):
    process, server, env = owner
    process.kill()
    wait_for(lambda: not server.is_running() or server.status() == psutil.STATUS_ZOMBIE)
    assert ended(tmp_path, (*SMALL, "-o", "made.npz"), env)[-1] == 0


def test_a_server_of_another_python_is_not_asked(monkeypatch):
    monkeypatch.setenv(warm.VARIABLE, "/another/prefix:name")
    assert warm.status_of(["snakefile"]) is None


def test_what_a_child_loads_the_next_one_finds_loaded(tmp_path, monkeypatch):
    (tmp_path / "loaded_late.py").write_text("")
    monkeypatch.syspath_prepend(str(tmp_path))
    loader, missing = warm.Loader(lambda verb: None), os.memfd_create("missing")

    def run(words):
        import loaded_late  # noqa: F401

        return len(words)

    child = os.fork()
    if not child:
        os._exit(loader.run(run, ["two", "words"], missing))
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 2
    loader.learn("verb", missing)
    loader.prepare("other")
    assert "loaded_late" not in sys.modules
    loader.prepare("verb")
    assert "loaded_late" in sys.modules


@pytest.mark.parametrize("is_warm", [False, True])
def test_costs_stand_in_the_columns_of_snakemake(owner, tmp_path, is_warm):
    env = (owner[2] if is_warm else dict(os.environ)) | {costs.VARIABLE: "costs/one.tsv"}
    began = time.monotonic()
    assert ended(tmp_path, (*SMALL, "-o", "made.npz"), env)[-1] == 0
    seconds = time.monotonic() - began
    with open(tmp_path / "costs" / "one.tsv", newline="") as stream:
        (row,) = csv.DictReader(stream, delimiter="\t")
    assert list(row) == BenchmarkRecord.get_header()
    assert (
        0 < float(row["s"]) < seconds and 0 < float(row["cpu_time"]) and 20 < float(row["max_rss"]) < 2000
    )
    assert (
        ended(tmp_path, ("size", "none.vtp", "-o", "x.npz"), env | {costs.VARIABLE: "failed.tsv"})[-1] == 1
    )
    assert not (tmp_path / "failed.tsv").exists()

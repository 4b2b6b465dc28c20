"""Modules compiled on a full disk can be imported when there is room again."""

import os
import subprocess
import sys

IMPORT = "import sys, craftmesh; sys.path.insert(0, sys.argv[1]); import module; print(len(module.NUMBERS))"
# files of at most 200 bytes, as on a disk that is full beyond them
FULL = "import craftmesh, resource; resource.setrlimit(resource.RLIMIT_FSIZE, (200, 200)); " + IMPORT


def test_no_compiled_module_is_cut_short_by_a_full_disk(tmp_path):
    (tmp_path / "module.py").write_text(f"NUMBERS = {tuple(range(1000))}\n")
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}

    def run(code):
        words = [sys.executable, "-c", code, str(tmp_path)]
        return subprocess.run(words, env=environment, capture_output=True, text=True)

    full = run(FULL)
    assert full.stdout == "1000\n", full.stderr
    assert list(tmp_path.rglob("*.pyc")) == []
    again = run(IMPORT)
    assert again.stdout == "1000\n", again.stderr
    assert len(list(tmp_path.rglob("*.pyc"))) == 1

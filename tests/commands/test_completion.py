"""The completion of the shell knows every verb and its options."""

import shutil
import subprocess

import pytest

from craftmesh.cli import main
from craftmesh.commands.completion import SHELLS
from craftmesh.commands.verbs import VERBS


@pytest.mark.parametrize("shell", SHELLS)
def test_each_shell_has_a_script_that_names_every_verb(shell, capsys):
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    assert all(verb in script for verb in VERBS)
    assert "volume-tolerance" in script


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash")
def test_bash_completes_verbs_options_and_choices(capsys, tmp_path):
    assert main(["completion", "bash"]) == 0
    script = tmp_path / "completion.sh"
    script.write_text(capsys.readouterr().out)

    def completed(*words):
        line = f"source {script}; COMP_WORDS=({' '.join(words)}); COMP_CWORD={len(words) - 1}; "
        call = "$(complete -p craftmesh | sed 's/.*-F \\([^ ]*\\).*/\\1/'); echo ${COMPREPLY[@]}"
        done = subprocess.run(["bash", "-c", line + call], capture_output=True, text=True, check=True)
        return done.stdout.split()

    assert completed("craftmesh", "grad") == ["gradate"]
    assert "--split-ratio" in completed("craftmesh", "gradate", "--spl")
    assert "C3D10" in completed("craftmesh", "inp", "--element", "C3")

"""What `craftmesh init` writes runs as it is, up to a deck without fault."""

import subprocess
import sys
from pathlib import Path

import numpy as np

from craftmesh.deck.check_deck import check_deck
from craftmesh.voxels.generate import GenerateOptions, generate

ROOT = Path(__file__).resolve().parents[2]


def test_first_campaign_of_a_tiny_volume_gives_a_deck(tmp_path, run_snakemake):
    labels = generate(GenerateOptions(shape=(8, 9, 7), grains=2)).labels
    np.savez(tmp_path / "tiny.npz", labels=labels, spacing=[2.0, 2.0, 2.0])
    command = str(Path(sys.executable).parent / "craftmesh")
    done = subprocess.run([command, "init", "tiny.npz"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "craftmesh run " in done.stdout
    deck = tmp_path / "results/tiny/000/model.inp"
    flags = ("-s", str(ROOT / "Snakefile"), "--cores", "2", "--configfile", "tiny.yaml")
    run = run_snakemake(tmp_path, str(deck.relative_to(tmp_path)), *flags)
    assert run.status == 0, run.text[-2000:]
    assert check_deck(deck) == []
    assert "NSET=CRACK_FRONT" in deck.read_text()

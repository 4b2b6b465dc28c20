"""Where the disk is full or a folder is none, a verb ends in one line and leaves nothing half-written."""

import resource
import signal
from contextlib import contextmanager

import numpy as np
import pytest
from shown_models import asked, write_front, write_increment

from craftmesh.cli import main
from craftmesh.io.npz import write_labels
from craftmesh.types import Voxels

LIMIT = 512  # bytes a file may have, less than any that is written here
# OUT stands for the folder for what is written
LINES = [
    "generate --shape 20 20 20 --grains 4 -o OUT/made.npz",
    "init labels.npz -o OUT/first.yaml",
    "import labels.npz --image OUT/image.vti --labels OUT/labels.npz --islands OUT/islands.json",
    "remesh labels.npz -o OUT/remeshed.vtp",
    "crack labels.npz --centre 7 0 7.2 --radius 3 --l-min 0.5 -o OUT/crack.vtp",
    "stitch surface.vtp -o OUT/surface.vtp",
    "size surface.vtp --labels labels.npz --l-min 1 --l0 1 -o OUT/sizing.npz",
    "inp one/000/volume.vtu -o OUT/model.inp",
    "inp one/000/volume.vtu --includes -o OUT/model.inp",
    "solve one/000/volume.vtu --vtu OUT/solution.vtu -o OUT/solution.npz",
    *(f"export one/000/volume.vtu -o OUT/model.{kind}" for kind in ("msh", "vtu", "e", "exo")),
    "check one/000/volume.vtu --quality OUT/quality.json",
    "view one/000/volume.vtu -o OUT/seen.png",
    "view one/000/sif.csv -o OUT/seen.png",
    "depict one/000/volume.vtu -o OUT/pictures",
    "report . --campaign asked.json -o OUT/report.html",
]


@contextmanager
def little_room():
    """Let this process write no file over LIMIT bytes, as if the disk were full."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (LIMIT, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("files")
    labels = 1 + (np.indices((14, 14, 14))[1] > 7)
    write_labels(made / "labels.npz", Voxels(labels, np.ones(3), np.zeros(3)))
    assert main(["remesh", str(made / "labels.npz"), "-o", str(made / "surface.vtp")]) == 0
    write_increment(made / "one" / "000")
    write_front(made / "one" / "000", [1.0, 2.0, 3.0])
    asked(made, ["one"])
    return made


def refusal(words, capsys) -> str:
    capsys.readouterr()
    assert main(words) == 1
    lines = [line for line in capsys.readouterr().err.splitlines() if "error" in line.lower()]
    assert len(lines) == 1 and lines[0].startswith("craftmesh: error: "), lines
    return lines[0]


@pytest.mark.sampled(3)
@pytest.mark.parametrize("line", LINES)
def test_a_full_disk_is_one_line_and_nothing_half_written(line, folder, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(folder)
    words = line.replace("OUT", str(tmp_path)).split()
    assert main(words) == 0  # what there is to write, and the modules of the verb
    whole = {path.name: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    assert max(map(len, whole.values())) > LIMIT
    for path in sorted(tmp_path.rglob("*"), reverse=True):
        path.rmdir() if path.is_dir() else path.unlink()
    with little_room():
        said = refusal(words, capsys)
    # a report writes the record of its case first
    first = "one/case.json: " if line.startswith("report") else f"{tmp_path}/"
    assert first in said and "cannot be written" in said
    left = {path.name: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    assert left.items() <= whole.items() and all(len(bytes_) <= LIMIT for bytes_ in left.values())


@pytest.mark.parametrize("line", LINES)
def test_a_place_where_nothing_can_be_written_is_named(line, folder, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(folder)
    (tmp_path / "file").write_text("no folder")
    said = refusal(line.replace("OUT", str(tmp_path / "file")).split(), capsys)
    assert f"{tmp_path}/file/" in said and f"cannot be written ({tmp_path}/file is not a folder)" in said
    assert (tmp_path / "file").read_text() == "no folder"

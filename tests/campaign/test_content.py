"""Digests of what stages read: by all bytes that count, and by nothing else."""

import hashlib
import json
import os
import shutil
import time
from pathlib import Path

import numpy as np
import pytest
import tifffile

from craftmesh.campaign import file_digest
from craftmesh.campaign.file_digest import KEPT, digest_of

FUTURE = 4e9  # s, after any change that a test makes


def mhd(folder: Path) -> tuple[Path, Path]:
    text = "NDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = below/v.raw\n"
    return header(folder / "v.mhd", text, folder / "below" / "v.raw")


def nhdr(folder: Path) -> tuple[Path, Path]:
    text = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: v.raw\n"
    return header(folder / "v.nhdr", text, folder / "v.raw")


def tesr(folder: Path) -> tuple[Path, Path]:
    text = "***tesr\n **data\n   ascii\n  1 2\n **oridata\n rodrigues\n binary\n  *file v.ori\n***end\n"
    return header(folder / "v.tesr", text, folder / "v.ori")


def gltf(folder: Path) -> tuple[Path, Path]:
    text = json.dumps({"buffers": [{"uri": "v.bin"}, {"uri": "data:base64,AAAA"}]})
    return header(folder / "v.gltf", text, folder / "v.bin")


def glb(folder: Path) -> tuple[Path, Path]:
    chunk = json.dumps({"buffers": [{"uri": "v.bin"}, {"byteLength": 4}]})
    head = b"glTF" + b"\0" * 8 + len(chunk).to_bytes(4, "little") + b"JSON"
    return header(folder / "v.glb", head.decode() + chunk, folder / "v.bin")


def header(path: Path, text: str, data: Path) -> tuple[Path, Path]:
    path.write_text(text)
    data.parent.mkdir(exist_ok=True)
    data.write_bytes(bytes(range(8)))
    return path, data


def slices(folder: Path) -> tuple[Path, Path]:
    for k in range(3):
        page = np.full((2, 3), k, np.uint8)
        tifffile.imwrite(folder / "s" / f"s_{k}.tif", page, photometric="minisblack")
    return folder / "s", folder / "s" / "s_1.tif"


def table(folder: Path) -> tuple[Path, Path]:
    path = folder / "points.csv"
    path.write_text("x,y,z\n1,2,3\n")
    return path, path


def linked(folder: Path) -> tuple[Path, Path]:
    path, data = table(folder)
    (folder / "link.csv").symlink_to(path.name)
    return folder / "link.csv", data


def other_bytes(file: Path) -> bytes:
    old = file.read_bytes()
    return old[:-1] + bytes([old[-1] ^ 1])


def rewritten(file: Path) -> None:
    file.write_bytes(other_bytes(file))


def replaced_by_an_older_one(file: Path) -> None:
    other = file.with_name("older")
    other.write_bytes(other_bytes(file))
    os.utime(other, (1e9, 1e9))
    other.replace(file)


def rewritten_within_its_time(file: Path) -> None:
    """As `cp -p` over it: size, time and place on the disk are those of before."""
    before = file.stat()
    rewritten(file)
    os.utime(file, ns=(before.st_atime_ns, before.st_mtime_ns))


def touched(file: Path) -> None:
    os.utime(file, (FUTURE, FUTURE))


def copied_back(file: Path) -> None:
    other = file.with_name("copy")
    shutil.copy(file, other)
    other.replace(file)


CHANGES = (rewritten, replaced_by_an_older_one, rewritten_within_its_time)
SAME = (touched, copied_back)


@pytest.fixture(autouse=True)
def in_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "s").mkdir()


def anew(path: Path) -> str:
    """Return a digest as the next process finds it."""
    digest_of.cache_clear()
    return digest_of(str(path.absolute()))


def settle() -> None:
    """Let the digests that are kept count as older than a tick of the clock."""
    for entry in KEPT.glob("*.json"):
        os.utime(entry, (FUTURE, FUTURE))
    time.sleep(0.02)  # s: files' times advance every 4 ms or 10 ms


@pytest.mark.parametrize("settled", [True, False])
@pytest.mark.parametrize("change", [*CHANGES, *SAME])
@pytest.mark.parametrize("make", [mhd, nhdr, tesr, gltf, glb, slices, table, linked])
def test_a_digest_goes_by_content_alone(make, change, settled):
    path, data = make(Path("data"))
    before = anew(path)
    if settled:
        settle()
    change(data)
    assert (anew(path) != before) == (change in CHANGES)


@pytest.mark.parametrize("change", ["removed", "added", "exchanged", "renamed", "hidden beside them"])
def test_slices_are_those_of_a_stack_in_their_order(change):
    folder, _ = slices(Path("data"))
    before = anew(folder)
    settle()
    if change == "removed":
        (folder / "s_2.tif").unlink()
    elif change == "added":
        shutil.copy(folder / "s_2.tif", folder / "s_3.tif")
    elif change == "exchanged":
        (folder / "s_1.tif").rename(folder / "x")
        (folder / "s_2.tif").rename(folder / "s_1.tif")
        (folder / "x").rename(folder / "s_2.tif")
    elif change == "renamed":
        for k in range(3):
            (folder / f"s_{k}.tif").rename(folder / f"slice{k + 7}.tif")
    else:
        (folder / ".DS_Store").touch()
    assert (anew(folder) != before) == (change in ("removed", "added", "exchanged"))


def test_a_header_that_names_other_data_has_another_digest():
    path, data = mhd(Path("data"))
    before = anew(path)
    settle()
    shutil.copy(data, data.with_name("w.raw"))
    rewritten(data.with_name("w.raw"))
    path.write_text(path.read_text().replace("v.raw", "w.raw"))
    assert anew(path) != before


@pytest.mark.parametrize("make", [mhd, nhdr, tesr, gltf, slices, table])
def test_what_cannot_be_read_is_left_for_the_stage_to_say(make):
    path, data = make(Path("data"))
    kept, before = data.read_bytes(), anew(path)
    data.unlink()
    assert anew(path) != before
    data.write_bytes(kept)
    assert anew(path) == before


def test_files_that_stay_are_read_once(monkeypatch):
    path, _ = mhd(Path("data"))
    before = anew(path)
    settle()
    monkeypatch.setattr(file_digest, "files_behind", None)
    monkeypatch.setattr(hashlib, "file_digest", None)
    assert anew(path) == before


def test_a_folder_that_cannot_be_written_to_keeps_nothing():
    path, _ = table(Path("data"))
    Path(".snakemake").touch()
    assert anew(path) == anew(path)

"""Folders of TIFF slices: one stack by the number in its names, or one line that names two files."""

import os
import string
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
import tifffile
from hypothesis import given
from hypothesis import strategies as st

from craftmesh.errors import CraftmeshError
from craftmesh.io.tiff import read_tiff, slice_files

SLICE = np.arange(6, dtype=np.uint8).reshape(2, 3)


def write(path: Path, page: np.ndarray = SLICE, **how) -> None:
    tifffile.imwrite(path, page, **{"photometric": "minisblack", **how})


def folder(place: Path, *names: str) -> Path:
    for k, name in enumerate(names):
        write(place / name, SLICE + k)
    return place


def refusal(path: Path) -> str:
    with pytest.raises(CraftmeshError) as caught:
        read_tiff(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


texts = st.text(string.ascii_letters + "-_. ()é", max_size=6)
stems = st.tuples(texts, st.integers(0, 99), texts).map(lambda parts: "{}{}x{}".format(*parts))


@given(
    stem=stems.filter(lambda s: not s.startswith(".")),
    end=texts.filter(lambda s: not s.endswith(".")),
    first=st.integers(0, 1200),
    count=st.integers(2, 12),
    padding=st.lists(st.integers(0, 6), min_size=12, max_size=12),
    suffixes=st.lists(st.sampled_from([".tif", ".TIF", ".tiff"]), min_size=12, max_size=12),
    left_out=st.data(),
)
def test_slices_go_by_their_number_and_none_may_lack(stem, end, first, count, padding, suffixes, left_out):
    names = [f"{stem}{first + k:0{padding[k]}}{end}{suffixes[k]}" for k in range(count)]
    with TemporaryDirectory() as place:
        for name in (*names, "._" + names[0], ".hidden.tif", "Thumbs.db", "notes.txt"):
            (Path(place) / name).touch()
        assert [file.name for file in slice_files(Path(place))] == names
        if count > 2:
            gone = left_out.draw(st.integers(1, count - 2))
            (Path(place) / names[gone]).unlink()
            with pytest.raises(CraftmeshError, match="1 missing slices between") as caught:
                slice_files(Path(place))
            assert names[gone - 1] in str(caught.value) and names[gone + 1] in str(caught.value)


@pytest.mark.parametrize(
    "names, two, fault",
    [
        (("labels_0", "labels_1", "mask_0", "mask_1"), ("labels_0", "mask_0"), "only in one number"),
        (("s_0", "s_1", "s_1 (copy)"), ("s_0", "s_1 (copy)"), "only in one number"),
        (("s_0", "s_1", "s_1 (1)"), ("s_0", "s_1 (1)"), "only in one number"),
        (("c0_z0", "c0_z1", "c1_z0", "c1_z1"), ("c0_z0", "c1_z1"), "only in one number"),
        (("s_1", "s_2", "s_02"), ("s_2", "s_02"), "same number"),
        (("s_0", "s_5", "s_10"), ("s_0", "s_5"), "4 missing slices"),
        (("slice", "slice_1"), ("slice", "slice_1"), "only in one number"),
        (("run2_1", "run02_2"), ("run2_1", "run02_2"), "only in one number"),
    ],
)
def test_two_files_of_no_one_stack_are_named(tmp_path, names, two, fault):
    said = refusal(folder(tmp_path, *(f"{name}.tif" for name in names)))
    assert fault in said and all(f"{name}.tif" in said for name in two), said


@pytest.mark.parametrize("make", [Path.mkdir, lambda path: path.symlink_to("gone.tif"), os.mkfifo])
def test_no_slice_is_left_out_in_silence(tmp_path, make):
    stack = folder(tmp_path, "s_0.tif", "s_1.tif")
    make(stack / "s_2.tif")
    assert "s_2.tif: is a folder, broken link" in refusal(stack)


def test_slices_come_in_the_order_of_their_numbers(tmp_path):
    volume = read_tiff(folder(tmp_path, *(f"s{k}.tif" for k in range(12)))).labels
    assert volume.shape == (3, 2, 12)
    assert (np.diff(volume[0, 0].astype(int)) == 1).all()


def test_one_stack_alone_is_taken_and_not_beside_others(tmp_path):
    write(tmp_path / "stack.tif", np.stack([SLICE, SLICE + 1]))
    write(tmp_path / "._stack.tif")
    assert read_tiff(tmp_path).labels.shape == (3, 2, 2)
    (tmp_path / "stack.tif").rename(tmp_path / "stack1.tif")
    write(tmp_path / "stack2.tif", np.stack([SLICE, SLICE + 1]))
    assert "only one stack" in refusal(tmp_path)


@pytest.mark.parametrize(
    "other, words",
    [
        (SLICE[:, :2], "(2, 3) uint8, s2.tif has (2, 2) uint8"),
        (SLICE.astype(np.uint16), "s2.tif has (2, 3) uint16"),
        (np.stack([SLICE] * 3, axis=-1), "3 values per pixel"),
    ],
)
def test_pages_of_other_shape_type_or_colour(tmp_path, other, words):
    write(tmp_path / "s1.tif")
    write(tmp_path / "s2.tif", other, photometric="rgb" if other.ndim == 3 else "minisblack")
    assert words in refusal(tmp_path)


@pytest.mark.parametrize("last, count", [(SLICE, 3), (SLICE[:, :2], 0)])
def test_pages_written_one_by_one_are_one_stack_of_one_size(tmp_path, last, count):
    with tifffile.TiffWriter(tmp_path / "s.tif") as stack:
        for page in (SLICE, SLICE, last):
            stack.write(page, photometric="minisblack")
    if count:
        assert read_tiff(tmp_path / "s.tif").labels.shape == (3, 2, count)
    else:
        assert "2 sizes" in refusal(tmp_path / "s.tif")


@pytest.mark.parametrize("compression", [None, "zlib"])
def test_a_stack_that_was_cut_short_is_refused(tmp_path, capfd, compression):
    path = tmp_path / "s.tif"
    write(path, np.arange(6400, dtype=np.uint16).reshape(4, 40, 40), compression=compression, metadata=None)
    content = path.read_bytes()
    for share in (0.2, 0.5, 0.9):
        path.write_bytes(content[: int(share * len(content))])
        assert "s.tif" in refusal(path)
    assert capfd.readouterr().err == ""


def test_a_file_is_read_alone_whatever_others_its_head_names(tmp_path):
    names = [tmp_path / f"s{k}.ome.tif" for k in range(2)]
    planes = "".join(
        f'<TiffData FirstZ="{k}" PlaneCount="1"><UUID FileName="{name.name}">urn:uuid:{k}</UUID></TiffData>'
        for k, name in enumerate(names)
    )
    head = (
        '<OME xmlns="http://www.openmicroscopy.org/Schemas/OME/2016-06" UUID="urn:uuid:0">'
        '<Image ID="Image:0">'
        '<Pixels ID="Pixels:0" DimensionOrder="XYZCT" Type="uint8" SizeX="3" SizeY="2" SizeZ="2" SizeC="1" '
        f'SizeT="1"><Channel ID="Channel:0" SamplesPerPixel="1"/>{planes}</Pixels></Image></OME>'
    )
    for k, name in enumerate(names):
        write(name, SLICE + k, description=head.replace("urn:uuid:0", f"urn:uuid:{k}", 1), metadata=None)
    assert tifffile.imread(names[0]).shape == (2, 2, 3)
    assert read_tiff(tmp_path).labels.shape == (3, 2, 2)
    assert read_tiff(names[0]).labels.shape == (3, 2, 1)


@pytest.mark.parametrize("width", [3, 4])
def test_three_or_four_pixels_a_row_are_colours_only_where_the_file_says_so(width, tmp_path):
    labels = np.arange(5 * 6 * width, dtype=np.uint16).reshape(5, 6, width)
    tifffile.imwrite(tmp_path / "grey.tif", labels, photometric="minisblack", planarconfig="contig")
    assert (read_tiff(tmp_path / "grey.tif").labels == labels.transpose(2, 1, 0)).all()
    tifffile.imwrite(tmp_path / "colour.tif", labels, photometric="rgb")
    with pytest.raises(CraftmeshError, match=f"{width} values per pixel.*photometric='minisblack'"):
        read_tiff(tmp_path / "colour.tif")

"""What label 0 is taken for: what the format or the user says, else what the file shows; and it is said."""

import re

import h5py
import numpy as np
import pytest
import tifffile

from craftmesh.errors import CraftmeshError
from craftmesh.voxels.background import role_of_zero
from craftmesh.voxels.clean import CleanOptions, clean
from craftmesh.voxels.generate import GenerateOptions, generate
from craftmesh.voxels.reading import ReadOptions, read_voxels

SHAPE = (22, 21, 20)
X, Y, Z = np.indices(SHAPE)
CUBE = ReadOptions(spacing=(1, 1, 1), axes="xyz")


def grains(count=9, **noise) -> np.ndarray:
    options = GenerateOptions(
        shape=SHAPE, grains=count, voids=0, embedded_grains=0, embedded_pairs=0, **noise
    )
    return generate(options).labels.astype(np.int32)


def with_zero(where) -> np.ndarray:
    return np.where(where, 0, grains())


def balls(*centres, radius=2.5):
    place = np.stack([X, Y, Z], axis=-1)
    return np.any([((place - centre) ** 2).sum(-1) <= radius**2 for centre in centres], axis=0)


def beyond(radius):
    return (X - 10.5) ** 2 + (Y - 10) ** 2 > radius**2


def closed_up(labels):
    """Return labels whose ids have no gaps, as those of an image are: a cut may take a grain away."""
    return np.unique(labels, return_inverse=True)[1].reshape(SHAPE)


SITUATIONS = {
    "grains from 0": (grains() - 1, "grain"),
    "noisy grains from 0": (grains(shuffled=0.4) - 1, "grain"),
    "specks": (with_zero(np.random.default_rng(3).random(SHAPE) < 0.03), "unindexed"),
    "a round sample": (with_zero(beyond(9.5)), "void"),
    "space all round": (np.pad(grains(), 4), "void"),
    "space above": (with_zero(Z > 14), "void"),
    "pores": (with_zero(balls((5, 5, 5), (15, 8, 11), (9, 15, 13))), "void"),
}

FEW, STRAIGHT, SIZE, GAPS = "too few to compare", "meet it at right angles", "the grains have", "have gaps"
UNDECIDED = {
    "two layers": (X // 11, FEW),
    "two phases": (grains(20) % 2, FEW),
    "three phases": (grains(20) % 3, FEW),
    "a checkerboard": ((X + Y + Z) % 2, FEW),
    "bodies apart in a matrix": (np.where(balls((4, 4, 4), (15, 5, 12), (9, 16, 14)), 1, 0), FEW),
    "one grain with a notch": (np.where((Y < 9) & (abs(Z - 10) < 2), 0, 1), FEW),
    "ids with gaps from 0": (3 * (grains() - 1), GAPS),
    "a slot through the thickness": (closed_up(with_zero((Y < 9) & (abs(Z - 10) < 2))), STRAIGHT),
    "a blunt notch": (closed_up(with_zero((Y < 8) & (abs(X - 11) < 4))), STRAIGHT),
    "a drilled hole": (closed_up(with_zero((X - 11) ** 2 + (Y - 10) ** 2 < 16)), STRAIGHT),
    "a pit": (closed_up(with_zero((Y < 5) & (abs(Z - 9) < 2) & (abs(X - 12) < 2))), SIZE),
    "a cut corner": (closed_up(with_zero((X < 8) & (Z > 12))), STRAIGHT),
    "a missing quarter": (closed_up(np.where((X > 10) & (Y > 9), 0, grains(60))), SIZE),
    "pores that open": (
        closed_up(with_zero(balls((0, 5, 5), (15, 8, 0), (9, 20, 13), radius=4))),
        STRAIGHT,
    ),
    "one pore": (closed_up(with_zero(balls((11, 10, 10), radius=5))), STRAIGHT),
}


@pytest.mark.parametrize("situation", UNDECIDED)
def test_where_zero_does_not_look_like_a_grain_it_is_asked_for(tmp_path, situation):
    labels, why = UNDECIDED[situation]
    path = write_npz(tmp_path / "v", labels)
    with pytest.raises(CraftmeshError, match=rf"{re.escape(str(path))}: label 0, .*{why}") as refusal:
        read_voxels(path)
    assert "\n" not in str(refusal.value)
    for role in ("grain", "unindexed", "void"):
        assert role in str(refusal.value).split("--background")[1]
        raw = read_voxels(path, ReadOptions(background=role))
        assert (raw.voxels.labels > 0).sum() == (labels.size if role == "grain" else (labels > 0).sum())


@pytest.mark.parametrize(
    "options",
    [{}, {"size_spread": 0.5}, {"columnar_ratio": 3.0}, {"spacing": (1, 1, 3)}, {"raggedness": 0.7}],
    ids=["voronoi", "laguerre", "columns", "long voxels", "ragged"],
)
@pytest.mark.parametrize("count", [5, 12, 40])
def test_each_grain_may_have_the_id_zero(options, count):
    labels = grains(count, **options)
    roles = []
    for one in range(1, count + 1):  # its id and 0 change places
        given = np.where(labels == count, one, labels)
        roles.append(role_of_zero(np.where(labels == one, 0, given), ())[0])
    assert roles.count("grain") >= 0.8 * len(roles)  # measured: all, of long voxels but 1 of 5 and 1 of 12
    assert "void" not in roles


def write_npz(path, labels):
    np.savez(path.with_suffix(".npz"), labels=labels)
    return path.with_suffix(".npz")


def write_npy(path, labels):
    np.save(path.with_suffix(".npy"), labels)
    return path.with_suffix(".npy")


def write_tiff(path, labels):
    pages = labels.astype(np.uint16).transpose(2, 1, 0)
    tifffile.imwrite(path.with_suffix(".tif"), pages, photometric="minisblack")
    return path.with_suffix(".tif")


def write_nrrd(path, labels):
    import nrrd

    nrrd.write(str(path.with_suffix(".nrrd")), labels.astype(np.int32), {}, index_order="F")
    return path.with_suffix(".nrrd")


def write_mha(path, labels):
    head = f"DimSize = {' '.join(map(str, labels.shape))}\nElementType = MET_INT\nElementDataFile = LOCAL\n"
    data = labels.astype(np.int32).ravel(order="F").tobytes()
    path.with_suffix(".mha").write_bytes(head.encode() + data)
    return path.with_suffix(".mha")


def write_vti(path, labels, name="Spin"):
    extent = " ".join(f"0 {n}" for n in labels.shape)
    path.with_suffix(".vti").write_text(
        '<VTKFile type="ImageData" version="0.1" byte_order="LittleEndian">'
        f'<ImageData WholeExtent="{extent}"><Piece Extent="{extent}"><CellData>'
        f'<DataArray type="Int32" Name="{name}" format="ascii">'
        f"{' '.join(map(str, labels.ravel(order='F')))}"
        "</DataArray></CellData></Piece></ImageData></VTKFile>"
    )
    return path.with_suffix(".vti")


@pytest.mark.parametrize("situation", SITUATIONS)
@pytest.mark.parametrize("write", [write_npz, write_npy, write_tiff, write_nrrd, write_mha, write_vti])
def test_formats_that_do_not_say_what_zero_is(tmp_path, write, situation):
    labels, role = SITUATIONS[situation]
    path = write(tmp_path / "v", labels)
    raw = read_voxels(path, CUBE)
    voxels = (labels == 0).sum()
    (note,) = (note for note in raw.notes if note.startswith("label 0, "))
    assert raw.background == role and f"{voxels} voxels" in note
    others = {"grain", "unindexed", "void"} - {role}
    assert set(re.search("set background to (.*)", note)[1].split(" or ")) == others
    assert raw.unindexed.sum() == (voxels if role == "unindexed" else 0)
    assert ((raw.voxels.labels > 0) == ((labels > 0) | (role == "grain"))).all()
    assert len(np.unique(raw.voxels.labels)) == len(np.unique(labels))


@pytest.mark.parametrize("situation", SITUATIONS)
def test_who_fills_has_unindexed_voxels_and_is_told_so(tmp_path, situation):
    labels = SITUATIONS[situation][0]
    raw = read_voxels(write_npz(tmp_path / "v", labels), fills=True)
    assert raw.background == "unindexed" and raw.unindexed.sum() == (labels == 0).sum()
    assert any("because fill_unindexed is set" in note for note in raw.notes)


@pytest.mark.parametrize("role", ["grain", "unindexed", "void"])
def test_what_the_user_says_is_not_guessed(tmp_path, role):
    raw = read_voxels(write_npz(tmp_path / "v", grains() - 1), ReadOptions(background=role))
    assert raw.background == "" and not any("is taken as" in note for note in raw.notes)
    assert raw.unindexed.any() == (role == "unindexed")


def write_simpl(path, labels):
    with h5py.File(path.with_suffix(".dream3d"), "w") as file:
        image = file.create_group("DataContainers/Image")
        image["_SIMPL_GEOMETRY/DIMENSIONS"] = np.array(labels.shape)
        image["_SIMPL_GEOMETRY/SPACING"] = image["_SIMPL_GEOMETRY/ORIGIN"] = np.ones(3)
        image["CellData/FeatureIds"] = labels.transpose(2, 1, 0)[..., None]
    return path.with_suffix(".dream3d")


def write_labdct(path, labels):
    with h5py.File(path.with_suffix(".h5"), "w") as file:
        file["LabDCT/Spacing"], file["LabDCT/Data/GrainId"] = np.ones(3), labels.transpose(2, 1, 0)
    return path.with_suffix(".h5")


def write_tesr(path, labels):
    shape, values = (" ".join(map(str, some)) for some in (labels.shape, labels.ravel(order="F")))
    path.with_suffix(".tesr").write_text(
        f"***tesr\n **format\n 2.1\n **general\n 3\n {shape}\n 1 1 1\n **data\n ascii\n {values}\n***end\n"
    )
    return path.with_suffix(".tesr")


@pytest.mark.parametrize(
    "write, role",
    [
        (write_simpl, "unindexed"),
        (write_labdct, "unindexed"),
        (lambda path, labels: write_vti(path, labels, "FeatureIds"), "unindexed"),
        (write_tesr, "void"),
        (lambda path, labels: write_vti(path, labels, "material"), "grain"),
    ],
)
@pytest.mark.parametrize("situation", ["grains from 0", "specks", "pores"])
def test_formats_that_say_what_zero_is_are_believed(tmp_path, write, role, situation):
    labels = SITUATIONS[situation][0]
    raw = read_voxels(write(tmp_path / "v", labels.astype(np.int32)))
    assert raw.background == "" and raw.unindexed.any() == (role == "unindexed")
    assert (raw.voxels.labels > 0).all() == (role == "grain")


ROWS = np.random.default_rng(1).random((9, 3))


@pytest.mark.parametrize(
    "name, table, first, role",
    [
        ("eulers", ROWS, np.nan, "unindexed"),
        ("eulers", ROWS, 0, "unindexed"),
        ("rodrigues", ROWS, 0, "unindexed"),
        ("rodrigues", ROWS, 0.3, "grain"),
        ("phases", np.ones(9, int), 0, "unindexed"),
        ("phases", np.ones(9, int), 1, "grain"),
    ],
)
def test_a_row_that_zero_alone_lacks_says_it_is_no_grain(tmp_path, name, table, first, role):
    table = table.copy()
    table[0] = first
    np.savez(tmp_path / "v.npz", labels=grains() - 1, **{name: table})
    assert read_voxels(tmp_path / "v.npz").background == role


def test_tables_that_other_grains_lack_too_say_nothing_of_zero(tmp_path):
    np.savez(tmp_path / "v.npz", labels=grains() - 1, eulers=0 * ROWS)
    assert read_voxels(tmp_path / "v.npz").background == "grain"


def test_unindexed_voxels_that_are_not_filled_name_all_three_ways(tmp_path):
    raw = read_voxels(write_npz(tmp_path / "v", SITUATIONS["specks"][0]))
    with pytest.raises(
        CraftmeshError, match=r"%\) have no grain.*fill_unindexed.*background to void.*grain"
    ):
        clean(raw)
    report = clean(raw, CleanOptions(fill_unindexed=True))[1]
    assert any("fill_unindexed" in change and "%" in change for change in report["changes"])

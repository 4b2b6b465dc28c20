"""Files that declare what they do not hold, or name other files, end in one line and take no memory.

All are read by one process of its own, with little memory on top of what its imports take.
"""

import bz2
import gzip
import json
import subprocess
import sys
import zipfile
import zlib

import h5py
import numpy as np
import pytest
import tifffile

LABELS = np.repeat(np.arange(1, 9, dtype=np.int32), 8).reshape(4, 4, 4)
RAW = LABELS.tobytes()
HUGE = 4000  # voxels an axis: 64 GB at a byte each
MEMORY = 60  # MB that the process may take, for files of a few kB
SURFACES = (".stl", ".ply", ".off", ".3mf", ".gltf")
READ = f"""
SURFACES = {SURFACES}
import json, resource, sys
from pathlib import Path
from craftmesh.errors import CraftmeshError
from craftmesh.voxels.reading import ReadOptions, read_voxels
from craftmesh.io import hdf5_volumes, surface_files, vtk_xml
import lxml.etree, networkx, nrrd, tifffile, trimesh
import vtkmodules.vtkCommonDataModel, vtkmodules.util.numpy_support
taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (taken + {MEMORY} * 2**20,) * 2)
for name in sys.argv[1:]:
    try:
        if Path(name).suffix in SURFACES:
            said = str(surface_files.read_triangles(name)[1].shape)
            print(json.dumps([name, said]), flush=True)
            continue
        axes = "xyz" if name.endswith(".npy") else ""
        said = str(read_voxels(name, ReadOptions(axes=axes, spacing=(1, 1, 1))).voxels.labels.shape)
    except CraftmeshError as error:
        said = "refused: " + str(error)
    except BaseException as error:
        said = f"{{type(error).__name__}}: {{error}}"
    print(json.dumps([name, said]), flush=True)
"""


def npy_head(shape, kind="<i4", order=False) -> bytes:
    text = f"{{'descr': '{kind}', 'fortran_order': {order}, 'shape': {shape}}}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text.encode()


def npz(path, shape, packed=zipfile.ZIP_DEFLATED, zeros=0, data=RAW):
    with zipfile.ZipFile(path, "w", packed) as archive, archive.open("labels.npy", "w") as entry:
        entry.write(npy_head(shape) + data)
        for _ in range(zeros):
            entry.write(bytes(1 << 24))


def claim(path, packed):
    """Write an .npz whose list of entries says that its array unpacks to 4 GB."""
    npz(path, (1 << 30,), packed)
    content = path.read_bytes()
    at = content.rindex(b"PK\x01\x02") + 24
    path.write_bytes(content[:at] + (2**32 - 2).to_bytes(4, "little") + content[at + 4 :])


def mha(path, size="4 4 4", data=RAW, **more):
    head = {"DimSize": size, "ElementType": "MET_INT", "ElementSpacing": "1 1 1"} | more
    head["ElementDataFile"] = head.pop("ElementDataFile", "LOCAL")
    path.write_bytes("".join(f"{key} = {value}\n" for key, value in head.items()).encode() + data)


def nrrd(path, sizes="4 4 4", encoding="raw", data=RAW, more=""):
    head = f"NRRD0004\ntype: int32\nendian: little\ndimension: 3\nsizes: {sizes}\nencoding: {encoding}\n"
    head += more + "\n"
    path.write_bytes(head.encode() + data)


def tesr(path, size="4 4 4", data=b"binary32\n" + RAW, cell="8"):
    head = f"***tesr\n **format\n   2.1\n **general\n   3\n {size}\n 1 1 1\n **cell\n {cell}\n **data\n "
    path.write_bytes(head.encode() + data + b"\n***end\n")


def vti(path, end=4, whole=None, data=None, kind="appended", packed=False):
    data = len(RAW).to_bytes(4, "little") + RAW if data is None else data
    extent = f"0 {end} 0 {end} 0 {end}"
    how = 'compressor="vtkZLibDataCompressor"' if packed else ""
    head = (
        f'<VTKFile type="ImageData" byte_order="LittleEndian" header_type="UInt32" {how}>'
        f'<ImageData WholeExtent="{whole or extent}"><Piece Extent="{extent}">'
        f'<CellData><DataArray type="Int32" Name="labels" format="{kind}" offset="0"/></CellData></Piece>'
        '</ImageData><AppendedData encoding="raw">_'
    )
    path.write_bytes(head.encode() + data + b"</AppendedData></VTKFile>")


def words(*numbers) -> bytes:
    return np.array(numbers, np.uint32).tobytes()


def dream3d(path, fill, dims=(4, 4, 4)):
    with h5py.File(path, "w") as file:
        image = file.create_group("DataContainers/Image")
        image["_SIMPL_GEOMETRY/DIMENSIONS"] = np.array(dims)
        image["_SIMPL_GEOMETRY/SPACING"] = image["_SIMPL_GEOMETRY/ORIGIN"] = np.ones(3)
        fill(image.create_group("CellData"), path.parent)


def virtual(group, folder):
    layout = h5py.VirtualLayout((4, 4, 4), np.int32)
    layout[...] = h5py.VirtualSource(folder / "other.h5", "ids", (4, 4, 4))
    group.create_virtual_dataset("FeatureIds", layout)


def external(group, folder):
    group.create_dataset("FeatureIds", (4, 4, 4), np.int32, external=str(folder / "outside" / "data.raw"))


def link(group, folder):
    group["FeatureIds"] = h5py.ExternalLink(folder / "other.h5", "ids")


def huge(**how):
    return lambda group, _: group.create_dataset("FeatureIds", (HUGE,) * 3, np.int32, **how)


def ids(group, _):
    group["FeatureIds"] = LABELS


def tiff(path, **tags):
    """Write a stack whose tags of all pages are changed after it is whole."""
    tifffile.imwrite(path, LABELS, photometric="minisblack", compression=tags.pop("compression", None))
    with tifffile.TiffFile(path, mode="r+") as stack:
        for page in stack.pages:
            for name, value in tags.items():
                page.tags[name].overwrite(value)


def stl(path, count=2):
    path.write_bytes(bytes(80) + words(count) + (np.arange(12, dtype="<f4").tobytes() + b"\0\0") * 2)


def ply(path, points=3, faces=1, kind="ascii", data=b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"):
    head = f"ply\nformat {kind} 1.0\nelement vertex {points}\n" + "".join(
        f"property float {axis}\n" for axis in "xyz"
    )
    head += f"element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    path.write_bytes(head.encode() + data)


def gltf(path, uri):
    views = [
        {"buffer": 0, "byteOffset": 0, "byteLength": 36},
        {"buffer": 0, "byteOffset": 0, "byteLength": 12},
    ]
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
        {"bufferView": 1, "componentType": 5125, "count": 3, "type": "SCALAR"},
    ]
    content = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": uri, "byteLength": len(RAW)}],
        "bufferViews": views,
        "accessors": accessors,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
    }
    path.write_text(json.dumps(content))


def bomb_3mf(path):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        with archive.open("3D/3dmodel.model", "w") as entry:
            for _ in range(5):
                entry.write(bytes(1 << 24))


BOMB = bytes(20 << 20)
FAULTS = {
    "npy_shape.npy": lambda p: p.write_bytes(npy_head((HUGE,) * 3) + RAW),
    "npy_overflow.npy": lambda p: p.write_bytes(npy_head((2**32, 2**32, 2)) + RAW),
    "npy_negative.npy": lambda p: p.write_bytes(npy_head((-4, -4, 4)) + RAW),
    "npy_objects.npy": lambda p: np.save(p, LABELS.astype(object), allow_pickle=True),
    "npy_fields.npy": lambda p: np.save(p, np.zeros((4, 4, 4), [("id", "i4"), ("phase", "i4")])),
    "npy_cut.npy": lambda p: p.write_bytes(npy_head((4, 4, 4)) + RAW[:-5]),
    "npz_shape.npz": lambda p: npz(p, (HUGE,) * 3),
    "npz_negative.npz": lambda p: npz(p, (4, -4, 4)),
    "npz_bomb.npz": lambda p: npz(p, (5 << 22,), zeros=5, data=b""),
    "npz_deflated.npz": lambda p: claim(p, zipfile.ZIP_DEFLATED),
    "npz_memory.npz": lambda p: claim(p, zipfile.ZIP_BZIP2),
    "npz_objects.npz": lambda p: np.savez(p, labels=LABELS.astype(object)),
    "mha_size.mha": lambda p: mha(p, f"{HUGE} {HUGE} {HUGE}"),
    "mha_negative.mha": lambda p: mha(p, "-4 -4 4"),
    "mha_zero.mha": lambda p: mha(p, "4 0 4"),
    "mha_overflow.mha": lambda p: mha(p, "4294967296 4294967296 1"),
    "mha_beyond.mha": lambda p: mha(p, "99999999999999999999 4 4"),
    "mha_packed_size.mha": lambda p: mha(
        p, f"{HUGE} {HUGE} {HUGE}", zlib.compress(BOMB), CompressedData="True"
    ),
    "mha_nan.mha": lambda p: mha(p, ElementSpacing="nan 1 1"),
    "mhd_outside.mhd": lambda p: mha(p, data=b"", ElementDataFile="../outside/data.raw"),
    "mhd_absolute.mhd": lambda p: mha(p, data=b"", ElementDataFile=p.parent.parent / "outside/data.raw"),
    "mhd_linked.mhd": lambda p: mha(p, data=b"", ElementDataFile="link.raw"),
    "mhd_list.mhd": lambda p: mha(p, data=b"../outside/data.raw\n", ElementDataFile="LIST"),
    "mhd_pattern.mhd": lambda p: mha(p, data=b"", ElementDataFile="../outside/%d.raw 1 4 1"),
    "nrrd_sizes.nrrd": lambda p: nrrd(p, f"{HUGE} {HUGE} {HUGE}"),
    "npy_text.npy": lambda p: p.write_bytes(npy_head((9, 9, 9), "<U0") + RAW),
    "npy_count.npy": lambda p: p.write_bytes(npy_head((True, 4, 4)) + RAW),
    "nrrd_negative.nrrd": lambda p: nrrd(p, "4 -4 -4"),
    "nrrd_packed_sizes.nrrd": lambda p: nrrd(p, f"{HUGE} {HUGE} {HUGE}", "gzip", gzip.compress(BOMB)),
    "nrrd_skip.nrrd": lambda p: nrrd(p, more=f"byte skip: {HUGE**3}\n"),
    "nrrd_lines.nrrd": lambda p: nrrd(p, more=f"line skip: {HUGE**3}\n"),
    "nrrd_cut.nrrd": lambda p: nrrd(p, "4 4 4", "gzip", gzip.compress(RAW)[:-30]),
    "nrrd_outside.nhdr": lambda p: nrrd(p, data=b"", more="data file: ../outside/data.raw\n"),
    "nrrd_list.nhdr": lambda p: nrrd(p, data=b"../outside/data.raw\n", more="data file: LIST\n"),
    "tesr_size.tesr": lambda p: tesr(p, f"{HUGE} {HUGE} {HUGE}"),
    "tesr_negative.tesr": lambda p: tesr(p, "-4 -4 4"),
    "tesr_beyond.tesr": lambda p: tesr(p, "1e30 4 4"),
    "tesr_nan.tesr": lambda p: tesr(p, "nan 4 4"),
    "tesr_outside.tesr": lambda p: tesr(p, data=b"binary32\n*file ../outside/data.raw\n"),
    "tesr_nameless.tesr": lambda p: tesr(p, data=b"binary32\n*file"),
    "vti_extent.vti": lambda p: vti(p, 1700),
    "vti_whole.vti": lambda p: vti(p, 4, "0 1700 0 1700 0 1700"),
    "vti_packed.vti": lambda p: vti(
        p, 1700, data=words(1, 2**31, 0, 100) + zlib.compress(BOMB), packed=True
    ),
    "vti_blocks.vti": lambda p: vti(p, data=words(2**31, 2**31, 0, 0), packed=True),
    "vti_text.vti": lambda p: vti(p, 1700, kind="ascii"),
    "h5_huge.dream3d": lambda p: dream3d(p, huge(chunks=(64, 64, 64)), (HUGE,) * 3),
    "h5_packed.dream3d": lambda p: dream3d(p, huge(chunks=True, compression="gzip"), (HUGE,) * 3),
    "h5_plain.dream3d": lambda p: dream3d(p, huge(), (HUGE,) * 3),
    "h5_external.dream3d": lambda p: dream3d(p, external),
    "h5_link.dream3d": lambda p: dream3d(p, link),
    "h5_virtual.dream3d": lambda p: dream3d(p, virtual),
    "h5_negative.dream3d": lambda p: dream3d(p, ids, (-4, -4, 4)),
    "h5_dims.dream3d": lambda p: dream3d(p, ids, (4, 4)),
    "tif_width.tif": lambda p: tiff(p, ImageWidth=60000, ImageLength=60000, RowsPerStrip=60000),
    "tif_counts.tif": lambda p: tiff(p, ImageWidth=60000, ImageLength=60000, StripByteCounts=2**32 - 1),
    "stl_count.stl": lambda p: stl(p, 2**32 - 1),
    "ply_points.ply": lambda p: ply(p, 10**12),
    "ply_faces.ply": lambda p: ply(p, faces=10**12),
    "ply_binary.ply": lambda p: ply(p, 10**12, 10**12, "binary_little_endian"),
    "ply_negative.ply": lambda p: ply(p, -3),
    "off_counts.off": lambda p: p.write_text("OFF\n1000000000000 1000000000000 0\n0 0 0\n"),
    "3mf_bomb.3mf": bomb_3mf,
    "gltf_outside.gltf": lambda p: gltf(p, "../outside/data.raw"),
    "tif_packed.tif": lambda p: tiff(p, compression="zlib", ImageWidth=60000, ImageLength=60000),
}
SOUND = {
    "good.npy": lambda p: np.save(p, np.asfortranarray(LABELS)),
    "good.npz": lambda p: npz(p, (4, 4, 4)),
    "bzip2.npz": lambda p: npz(p, (4, 4, 4), zipfile.ZIP_BZIP2),
    "good.mha": lambda p: mha(p, data=b"skipped" + RAW, HeaderSize=-1),
    "packed.mha": lambda p: mha(p, data=zlib.compress(RAW), CompressedData="True"),
    "below.mhd": lambda p: mha(p, data=b"", ElementDataFile="below/data.raw"),
    "good.nrrd": lambda p: nrrd(p, more="byte skip: -1\n", data=b"skipped" + RAW),
    "packed.nrrd": lambda p: nrrd(p, "4 4 4", "bzip2", bz2.compress(RAW)),
    "below.nhdr": lambda p: nrrd(p, data=b"", more="data file: below/data.raw\n"),
    "good.tesr": tesr,
    "below.tesr": lambda p: tesr(p, data=b"binary32\n*file below/data.raw"),
    "good.vti": vti,
    "packed.vti": lambda p: vti(
        p,
        data=words(1, 256, 0, len(zlib.compress(RAW))) + zlib.compress(RAW),
        packed=True,
    ),
    "good.dream3d": lambda p: dream3d(p, ids),
    "below.gltf": lambda p: gltf(p, "below/data.raw"),
    "good.stl": stl,
    "good.ply": ply,
    "good.tif": lambda p: tiff(p, compression="zlib"),
}


@pytest.fixture(scope="module")
def said(tmp_path_factory):
    """Return what the process said of each file, by its name."""
    place = tmp_path_factory.mktemp("hostile")
    folder = place / "folder"
    for inside in (folder / "below", place / "outside", folder / "outside"):
        inside.mkdir(parents=True)
        (inside / "data.raw").write_bytes(RAW)
    (folder / "link.raw").symlink_to(place / "outside" / "data.raw")
    with h5py.File(folder / "other.h5", "w") as file:
        file["ids"] = LABELS
    for name, write in (FAULTS | SOUND).items():
        write(folder / name)
    line = [sys.executable, "-W", "ignore", "-c", READ, *FAULTS, *SOUND]
    done = subprocess.run(line, cwd=folder, capture_output=True, text=True, timeout=120)
    found = dict(json.loads(row) for row in done.stdout.splitlines())
    return {
        name: found.get(name, f"ended: {done.returncode} {done.stderr[-300:]}") for name in FAULTS | SOUND
    }


@pytest.mark.parametrize("name", FAULTS)
def test_false_files_are_one_line_that_names_them(said, name):
    assert said[name].startswith("refused: ") and name in said[name] and "\n" not in said[name], said[name]
    assert "memory" not in said[name] or "bomb" in name or name == "npz_memory.npz", said[name]


@pytest.mark.parametrize("name", SOUND)
def test_their_sound_likes_are_read(said, name):
    assert said[name] in ("(4, 4, 4)", "(2, 3)", "(1, 3)")

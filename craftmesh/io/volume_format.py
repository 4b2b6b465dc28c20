"""The format of a volume file, by name and content, and advice for files that contain no grains."""

from pathlib import Path

from craftmesh.errors import CraftmeshError, listed

AUTO = "auto"  # value of the option `format`: find the format by the file's name and content
SUFFIXES: dict[str, tuple[str, ...]] = {
    "npz": (".npz",),
    "npy": (".npy",),
    "dream3d": (".dream3d",),
    "vti": (".vti", ".vtr"),
    "labdct": (),
    "tiff": (".tif", ".tiff"),
    "tesr": (".tesr",),
    "metaimage": (".mha", ".mhd"),
    "nrrd": (".nrrd", ".nhdr"),
}
_BY_GROUP = {
    "LabDCT": "labdct",
    "DataContainers": "dream3d",
    "DataStructure": "dream3d",
    "VoxelDataContainer": "dream3d",
}
_MAP = "is an orientation map without grain ids; segment it first (DREAM.3D, MTEX, orix)"
_SURFACE = "is a surface; put one file per grain in a folder and run `craftmesh stitch FOLDER`"
_MESH = "is a mesh, not voxels; docs/library.md describes how to open a crack in it"
_PICTURE = "is a picture; save the slices as .tif in a folder, with one label per pixel"
_TABLE = "is a table of numbers; save the labels on a grid, as .npz with labels[x, y, z] and spacing"
_BARE = "has no header; write a .mhd that names it, with DimSize, ElementType and ElementSpacing"
_NO_GRAINS = {
    _MAP: (".ang", ".ctf", ".h5oina", ".crc", ".osc", ".h5ebsd", ".edaxh5"),
    _SURFACE: (".stl", ".ply", ".obj", ".off", ".3mf", ".vtp"),
    _MESH: (".vtu", ".msh", ".inp", ".e", ".exo"),
    _PICTURE: (".png", ".jpg", ".jpeg", ".bmp", ".gif"),
    _TABLE: (".csv", ".txt", ".dat", ".xlsx"),
    _BARE: (".raw", ".bin"),
    "is a tessellation of polyhedra; make voxels: `neper -T -loadtess FILE -format tesr -tesrsize 100`": (
        ".tess",
    ),
    "is legacy VTK; save an image as .vti, a rectilinear grid as .vtr: pyvista.read(FILE).save(NAME)": (
        ".vtk",
    ),
    "is a MATLAB file; load its array by scipy.io.loadmat(FILE)[NAME], or h5py.File(FILE)[NAME][()].T for "
    "-v7.3, and save it as .npz with labels[x, y, z] and spacing": (".mat",),
    "is a file of Avizo; export the label field as .mhd, .nrrd or a TIFF stack": (".am", ".hx"),
    "is a medical image; save it as .nrrd (3D Slicer, ITK-SNAP)": (".nii",),
    "refers to data in another file; give the .dream3d next to it": (".xdmf",),
    "cannot be read; for a DREAM.3D pipeline give the .dream3d that it writes; for Kanapy's voxels save "
    "numpy.reshape(Data.Values, Data.Shape) as .npz with labels and spacing, Model.Size / Data.Shape": (
        ".json",
    ),
    "is a file of DAMASK 2; make a .vti with DAMASK 3: damask.Grid.load_ASCII(FILE).save(NAME)": (".geom",),
}


def format_of(path: Path) -> str:
    """Return the format of a file or folder, a key of SUFFIXES: by its name, or for .h5 by its content.

    Raises CraftmeshError for files without grains, unknown suffixes, and HDF5 files of unknown content.
    """
    return format_by_name(path) or _of_hdf5(path)


def format_by_name(path: Path) -> str:
    """Return the format of a file or folder, a key of SUFFIXES; "" for .h5 and .hdf5.

    Raises CraftmeshError for files without grains, with advice how to convert them, and for unknown ones.
    """
    suffix, kind = path.suffix.lower(), format_of_suffix(path)
    if path.is_dir():
        if kind not in ("", "tiff"):
            raise CraftmeshError(f"{path}: is a folder; give a {suffix} file, or a folder of .tif slices")
        return "tiff"
    if kind:
        return kind
    for reason, suffixes in _NO_GRAINS.items():
        if suffix in suffixes:
            raise CraftmeshError(f"{path}: {reason}")
    if suffix in (".h5", ".hdf5"):
        return ""
    raise CraftmeshError(f"{path}: unknown suffix; set format to one of {', '.join(SUFFIXES)}")


def format_of_suffix(path: Path) -> str:
    """Return the format of a path's suffix, a key of SUFFIXES; "" for other suffixes."""
    suffix = path.suffix.lower()
    return next((kind for kind, suffixes in SUFFIXES.items() if suffix in suffixes), "")


def _of_hdf5(path: Path) -> str:
    from craftmesh.io.hdf5 import opened  # here because the import of h5py is slow

    with opened(path) as file:
        for group, kind in _BY_GROUP.items():
            if group in file:
                return kind
        if any(f"{name}/EBSD" in file for name in file):
            raise CraftmeshError(f"{path}: {_MAP}")
        raise CraftmeshError(f"{path}: has groups {listed(file)}; give a file with {', '.join(_BY_GROUP)}")

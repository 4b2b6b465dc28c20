"""Which format a file has, by its name and contents, and where to go with files that hold no grains."""

from pathlib import Path

from craftmesh.errors import CraftmeshError, listed

AUTO = "auto"  # the option that leaves the format to the file's name and contents
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
_SURFACE = "is a surface; put one file a grain in a folder and start at `craftmesh stitch FOLDER`"
_MESH = "is a mesh, not voxels; docs/library.md tells how to open a crack in it"
_PICTURE = "is a picture; save the slices as .tif in a folder, one label a pixel"
_TABLE = "is a table of numbers; put the labels on a grid, as .npz with labels[x, y, z] and spacing"
_BARE = "is bare numbers; write a header .mhd that names it, with DimSize, ElementType and ElementSpacing"
_NO_GRAINS = {
    _MAP: (".ang", ".ctf", ".h5oina", ".crc", ".osc", ".h5ebsd", ".edaxh5"),
    _SURFACE: (".stl", ".ply", ".obj", ".off", ".3mf", ".vtp"),
    _MESH: (".vtu", ".msh", ".inp", ".e", ".exo"),
    _PICTURE: (".png", ".jpg", ".jpeg", ".bmp", ".gif"),
    _TABLE: (".csv", ".txt", ".dat", ".xlsx"),
    _BARE: (".raw", ".bin"),
    "is a tessellation of polyhedra; `neper -T -loadtess FILE -format tesr -tesrsize 100` makes voxels": (
        ".tess",
    ),
    "is legacy VTK; pyvista.read(FILE).save(NAME) makes a .vti of an image, a .vtr of a rectilinear grid": (
        ".vtk",
    ),
    "is MATLAB's; scipy.io.loadmat(FILE)[NAME], of -v7.3 h5py.File(FILE)[NAME][()].T, is its array: save "
    "it as .npz with labels[x, y, z] and spacing": (".mat",),
    "is Avizo's own; export the label field as .mhd, .nrrd or a TIFF stack": (".am", ".hx"),
    "is a medical image; save it as .nrrd (3D Slicer, ITK-SNAP)": (".nii",),
    "names data in another file; give the .dream3d beside it": (".xdmf",),
    "is not read; of a DREAM.3D pipeline give the .dream3d that it writes, of Kanapy's voxels save "
    "numpy.reshape(Data.Values, Data.Shape) as .npz with labels and spacing, Model.Size / Data.Shape": (
        ".json",
    ),
    "is of DAMASK 2; damask.Grid.load_ASCII(FILE).save(NAME) of DAMASK 3 makes a .vti": (".geom",),
}


def format_of(path: Path) -> str:
    """Return the format of a file or folder, a key of SUFFIXES; errors as format_by_name."""
    return format_by_name(path) or _of_hdf5(path)


def format_by_name(path: Path) -> str:
    """Return the format of a file or folder, a key of SUFFIXES, "" for HDF5, where its contents tell.

    Raises CraftmeshError for files that hold no grains, with the way from there, and for unknown ones.
    """
    suffix, kind = path.suffix.lower(), format_of_suffix(path)
    if path.is_dir():
        if kind not in ("", "tiff"):
            raise CraftmeshError(
                f"{path}: is a folder; expected a {suffix} file, or a folder of .tif slices"
            )
        return "tiff"
    if kind:
        return kind
    for reason, suffixes in _NO_GRAINS.items():
        if suffix in suffixes:
            raise CraftmeshError(f"{path}: {reason}")
    if suffix in (".h5", ".hdf5"):
        return ""
    raise CraftmeshError(
        f"{path}: format not known by its name; give format as one of {', '.join(SUFFIXES)}"
    )


def format_of_suffix(path: Path) -> str:
    """Return the format, a key of SUFFIXES, that the suffix of a path belongs to; "" for other suffixes."""
    suffix = path.suffix.lower()
    return next((kind for kind, suffixes in SUFFIXES.items() if suffix in suffixes), "")


def _of_hdf5(path: Path) -> str:
    from craftmesh.io.hdf5 import opened  # h5py takes long to import, and names alone need none

    with opened(path) as file:
        for group, kind in _BY_GROUP.items():
            if group in file:
                return kind
        if any(f"{name}/EBSD" in file for name in file):
            raise CraftmeshError(f"{path}: {_MAP}")
        raise CraftmeshError(f"{path}: has groups {listed(file)}; expected one of {', '.join(_BY_GROUP)}")

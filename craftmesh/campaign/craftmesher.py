"""config.xml of craftmesher, the program of the paper, as a configuration of a campaign."""

from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from craftmesh.errors import CraftmeshError, existing

# Keys of config.xml that nothing here answers to, and why.
_NOT_CARRIED = {
    "stls": "microstructures stand in the sheet of cases; for surfaces run `craftmesh stitch FOLDER`",
    "binary": "the kind of .stl is told by the files",
    "writeBinarySave": "outputs are VTK XML files",
    "BackgroundSMeshQuality": "there is no background mesh",
    "gradationScheme": "there is one scheme; lengths follow Eq. 3",
    "defectType": "a front and a list of voids are told apart by the file",
    "refinement/refinement_passes": "rounds are counted otherwise; gradate.passes keeps its default",
    "coarsening/coarsening_passes": "rounds are counted otherwise; gradate.passes keeps its default",
    "coarsening/SmoothBoundary": "the remeshed surface is smooth; see the section remesh",
}
# What craftmesher takes where its file does not say.
_DEFAULTS = {
    "a": "3",
    "coarsening/EdgeSmoothing": "2",
    "coarsening/RemoveHourglass": "1",
    "coarsening/Condense3": "1",
}
_SIZES = (
    "OriginalEdgeLength",
    "R0",
    "Rt",
    "refinement/SurfaceTargetEdgeLength",
    "refinement/VolumeTargetEdgeLength",
    "coarsening/SurfaceTargetEdgeLength",
    "coarsening/VolumeTargetEdgeLength",
)
_SHRINK = tuple(f"advCrackFileShrink{axis}" for axis in "XYZ")


def read_config(path: Path) -> dict[str, str]:
    """Read a config.xml: texts by key, those of nested elements as outer/inner.

    Raises CraftmeshError for a file that is missing or not XML, and for a key that is there twice.
    """
    try:
        root = ElementTree.parse(existing(path)).getroot()
    except ElementTree.ParseError as error:
        raise CraftmeshError(f"{path}: not XML ({error}); expected craftmesher's config.xml") from None
    found: dict[str, str] = {}
    for prefix, element in _leaves(root, ""):
        if prefix in found:
            raise CraftmeshError(f"{path}: key {prefix} is there twice; keep one")
        found[prefix] = (element.text or "").strip()
    return found


def _leaves(element: ElementTree.Element, prefix: str) -> Iterator[tuple[str, ElementTree.Element]]:
    for child in element:
        name = f"{prefix}{child.tag}"
        if len(child):
            yield from _leaves(child, f"{name}/")
        else:
            yield name, child


def converted(keys: dict[str, str], folder: Path) -> tuple[dict, list[str]]:
    """Return the sections of our configuration for craftmesher's `keys`, and what they leave out.

    folder: where config.xml is and its paths start. Each note is one line that begins with the key.
    Raises CraftmeshError, naming the key, for a value that is not the number it should be.
    """
    keys = _DEFAULTS | {key: text for key, text in keys.items() if text}
    notes = [f"{key}: {why}" for key, why in _NOT_CARRIED.items() if key in keys]
    sizing = _sizing(keys, notes) | _points(keys, folder, notes)
    gradate = {
        "release_tied_nodes": bool(_number(keys, "coarsening/RemoveHourglass")),
        "remove_unnecessary_nodes": bool(_number(keys, "coarsening/Condense3")),
        "junction_smoothing": int(_number(keys, "coarsening/EdgeSmoothing")),
    }
    config = {"sizing": sizing, "gradate": gradate}
    if "TetGenQualityMeasure" in keys:
        config["tetrahedralize"] = _tetgen_bounds(keys["TetGenQualityMeasure"], notes)
    if not _number(keys, "detectIslands", 1.0):
        notes.append("detectIslands: embedded grains and voids are always found")
    known = {*_NOT_CARRIED, *_DEFAULTS, *_SHRINK, *_SIZES, "TetGenQualityMeasure", "detectIslands"}
    notes += [f"{key}: an unknown key" for key in keys if key not in known | {"advancingCrackFile"}]
    return {name: section for name, section in config.items() if section}, notes


def _sizing(keys: dict[str, str], notes: list[str]) -> dict:
    l0, r0, rt, near, near_inside, far, far_inside = (_number(keys, key) for key in _SIZES)
    if not l0:
        notes.append("OriginalEdgeLength: none is given; sizing.l0 is then the voxel's edge")
    if near and near_inside and near != near_inside:
        notes.append(f"{_SIZES[4]}: one length near the defects serves surface and inside, {near:g}")
    if far_inside and far_inside != far:
        notes.append(f"{_SIZES[6]}: edges inside the grains follow Eq. 3 as those of the surface do")
    if rt:
        notes.append("Rt: taken as R_1, a distance from the defect" + (", R0 added" if rt < r0 else ""))
    sizing = {
        "l_min": near or near_inside,
        "l0": l0,
        "l_max": far,
        "r0": r0,
        "r1": rt + r0 if rt < r0 and rt else rt,
        "exponent": _number(keys, "a"),
    }
    return {key: value for key, value in sizing.items() if value}


def _points(keys: dict[str, str], folder: Path, notes: list[str]) -> dict:
    if "advancingCrackFile" not in keys:
        return {}
    factors = [_number(keys, key, 1.0) for key in _SHRINK]
    if any(factor != 1.0 for factor in factors):
        notes.append(f"{_SHRINK[0]}, Y, Z: the factors {factors} are left out; scale the file's points")
    notes.append(
        "advancingCrackFile: sizes follow it (sizing.points); a crack to insert stands under cracks, with "
        "shape fronts and that file"
    )
    return {"points": (folder / keys["advancingCrackFile"]).as_posix()}


def _tetgen_bounds(text: str, notes: list[str]) -> dict:
    parts = text.strip().lstrip("-").lstrip("q").split("/")
    try:
        bounds = [float(part) for part in parts]
    except ValueError:
        bounds = []
    if not 0 < len(bounds) <= 2 or not np.isfinite(bounds).all() or bounds[0] < 1 or min(bounds) < 0:
        notes.append(f"TetGenQualityMeasure: {text!r} is not RATIO/ANGLE; see tetrahedralize.switches")
        return {}
    return dict(zip(("radius_edge_ratio", "min_dihedral"), bounds))


def _number(keys: dict[str, str], key: str, default: float = 0.0) -> float:
    try:
        value = float(keys.get(key, default))
    except ValueError:
        value = np.nan
    if not np.isfinite(value) or value < 0:
        raise CraftmeshError(f"{key} is {keys[key]!r}; expected a number >= 0")
    return value

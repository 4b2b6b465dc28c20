"""Conversion of config.xml, the input of the paper's program craftmesher, to a campaign's configuration."""

from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from craftmesh.errors import CraftmeshError, existing

# Keys of config.xml that have no counterpart here, each with the note for the user.
_NOT_CARRIED = {
    "stls": "name microstructures in the case table; for surfaces run `craftmesh stitch FOLDER`",
    "binary": "binary and text .stl are recognised by content",
    "writeBinarySave": "outputs are VTK XML files",
    "BackgroundSMeshQuality": "there is no background mesh",
    "gradationScheme": "there is only one scheme; edge lengths follow Eq. 3",
    "defectType": "a front and a list of voids are distinguished by the file's columns",
    "refinement/refinement_passes": "passes are counted differently; gradate.passes keeps its default",
    "coarsening/coarsening_passes": "passes are counted differently; gradate.passes keeps its default",
    "coarsening/SmoothBoundary": "the remeshed surface is already smooth; see the section remesh",
}
# Defaults of craftmesher for keys that its file leaves out.
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
    """Return the texts of a config.xml by key; the key of a nested element is outer/inner.

    Raises CraftmeshError for a file that is missing or not XML, and for a duplicate key.
    """
    try:
        root = ElementTree.parse(existing(path)).getroot()
    except ElementTree.ParseError as error:
        raise CraftmeshError(f"{path}: not XML ({error}); give the config.xml of craftmesher") from None
    found: dict[str, str] = {}
    for prefix, element in _leaves(root, ""):
        if prefix in found:
            raise CraftmeshError(f"{path}: duplicate key {prefix}; keep one")
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
    """Return the sections of a craftmesh configuration made from craftmesher's `keys`, and notes.

    keys: as from `read_config`; folder: the folder of config.xml, to which its paths are relative. Each
    note is one line that begins with a key and says how its value is used, or why it is not. Raises
    CraftmeshError, naming the key, for a value that is not a number >= 0.
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
        notes.append("detectIslands: embedded grains and voids are always detected")
    known = {*_NOT_CARRIED, *_DEFAULTS, *_SHRINK, *_SIZES, "TetGenQualityMeasure", "detectIslands"}
    notes += [f"{key}: unknown key, not used" for key in keys if key not in known | {"advancingCrackFile"}]
    return {name: section for name, section in config.items() if section}, notes


def _sizing(keys: dict[str, str], notes: list[str]) -> dict:
    l0, r0, rt, near, near_inside, far, far_inside = (_number(keys, key) for key in _SIZES)
    if not l0:
        notes.append("OriginalEdgeLength: not given, so sizing.l0 is the voxel's edge length")
    if near and near_inside and near != near_inside:
        notes.append(f"{_SIZES[4]}: not used; sizing.l_min {near:g} holds on surfaces and inside grains")
    if far_inside and far_inside != far:
        notes.append(f"{_SIZES[6]}: not used; edges inside grains follow Eq. 3, as on the surface")
    if rt:
        notes.append("Rt: used as R_1, a distance from the defect" + (", plus R0" if rt < r0 else ""))
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
        notes.append(f"{_SHRINK[0]}, Y, Z: factors {factors} are not used; scale the points in the file")
    notes.append(
        "advancingCrackFile: used for edge lengths only (sizing.points); to insert the crack, add it under "
        "cracks with shape fronts and this file"
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

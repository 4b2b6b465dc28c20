"""A first configuration for a microstructure: edge lengths from voxels and grains, a crack in a face."""

import csv
import io
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import scipy

from craftmesh.campaign.cases import SYNTHETIC
from craftmesh.io.file_volume import of_grains
from craftmesh.mechanics.crystals import known_material
from craftmesh.sizing.sizing import voxel_edge
from craftmesh.types import Crystal, Voxels
from craftmesh.voxels.mouth import Mouth, find_mouth
from craftmesh.voxels.voxel_graph import median_grain

# l_min, l_max and r0 over l0. The default of l_min, l0 / 2, would triple the number of elements around the
# front; the examples use 0.75 to 0.8.
L_MIN, L_MAX, R0 = 0.8, 3.0, 8.0
ACROSS = 4.0  # smallest number of elements across the median grain; fewer do not resolve curved boundaries
RADIUS = 0.25  # crack radius over the shortest edge of the body's bounding box, which leaves room to grow
GROWTH = 0.25  # increase of the radius in an increment, over the radius
_ABOUT = {"background": "  # meaning of label 0: grain, void, or unindexed (filled from neighbours)"}
OFF_CENTRE = 0.2  # voxels, shift of the crack off planes between voxels, where flat boundaries lie


class FirstMaterial(NamedTuple):
    """A value of inp.material, its description, and whether it is a placeholder for unknown constants."""

    text: str
    about: str
    is_stand_in: bool


@dataclass(frozen=True)
class FirstCampaign:
    """Values of a first configuration, in model units, and facts about the microstructure.

    imported: keys of the section import; sizing: l0, l_min, l_max, r0, r1; crack: centre, normal, radius,
    growth; mouth: where the crack meets the surface; loads_faces: whether material touches both box faces
    that the tension loads; materials: for inp.material; grains: number of grains; across: median grain
    diameter.
    """

    imported: Mapping[str, Any]
    sizing: Mapping[str, float]
    crack: Mapping[str, Any]
    mouth: Mouth
    loads_faces: bool
    materials: tuple[FirstMaterial, ...]
    grains: int
    across: float


def first_campaign(voxels: Voxels, imported: Mapping[str, Any]) -> FirstCampaign:
    """Return a first campaign for cleaned voxels: target lengths, a crack in a face, and materials.

    imported: the import keys with which the voxels were read.
    """
    edge = voxel_edge(voxels)
    across = edge * float(np.cbrt(6 / np.pi * median_grain(voxels.labels)))
    (window,) = scipy.ndimage.find_objects((voxels.labels != 0).astype(np.int8))
    body = voxels.labels[window] != 0
    extent = body.shape * voxels.spacing
    l0 = min(edge, across / ACROSS)
    l_max = min(L_MAX * l0, max(l0, across / ACROSS))
    r0 = min(R0 * l0, extent.min() / 4)
    sizing = {"l0": l0, "l_min": L_MIN * l0, "l_max": l_max, "r0": r0, "r1": 2 * r0}
    radius = RADIUS * float(extent.min())
    mouth = find_mouth(body, voxels.spacing, radius, GROWTH * radius)
    off_planes = np.where(np.arange(3) == "xyz".index(mouth.face[0]), 0.0, OFF_CENTRE)
    place = [part.start for part in window] + mouth.place + off_planes
    crack = {
        "centre": (voxels.origin + voxels.spacing * place).tolist(),
        "normal": np.eye(3, dtype=int)[mouth.normal].tolist(),
        "radius": mouth.radius,
        "growth": GROWTH * mouth.radius,
    }
    grains = len(np.unique(voxels.labels[voxels.labels > 0]))
    part, cells = window[mouth.normal], voxels.labels.shape[mouth.normal]
    loads_faces = part.start == 0 and part.stop == cells
    return FirstCampaign(imported, sizing, crack, mouth, loads_faces, _materials(voxels), grains, across)


def _materials(voxels: Voxels) -> tuple[FirstMaterial, ...]:
    """Return a material for each phase of the grains: a crystal if all orientations are known.

    Otherwise the materials are isotropic placeholders.
    """
    grains = np.unique(voxels.labels[voxels.labels > 0])
    known = voxels.orientations is not None and np.isfinite(voxels.orientations[grains]).all()
    phases = np.unique(voxels.phases[grains]) if voxels.phases is not None else np.zeros(1, int)
    crystals = of_grains(voxels.crystals, voxels.phases)
    found = []
    for phase in phases.tolist():
        crystal = crystals.get(phase, Crystal())
        text, what, is_stand_in = known_material(crystal)
        if not known:
            text, what, is_stand_in = "isotropic:200000,0.3", "isotropic, as orientations are unknown", True
        own = " ".join(" ".join(crystal).split()) or "unknown crystal"
        about = f"{what}, in MPa" + (f", a placeholder for phase {phase} ({own})" if is_stand_in else "")
        found.append(FirstMaterial(text if len(phases) < 2 else f"{phase}={text}", about, is_stand_in))
    return tuple(found)


def configuration_text(first: FirstCampaign, name: str, sheet: str, data: str) -> str:
    """Return the first campaign's configuration as commented YAML for `snakemake --configfile`.

    name: the microstructure's name, for the heading; sheet: path of the case table; data: folder of the
    volume.
    """
    numbers = {key: _number(value) for key, value in ({**first.sizing, "across": first.across}).items()}
    imported = "".join(
        f"  {key}: {_yaml(value)}{_ABOUT.get(key, '')}\n" for key, value in first.imported.items()
    )
    section = f"import:  # how the file is read and cleaned\n{imported}\n" if imported else ""
    centre = ", ".join(_number(x, 6) for x in first.crack["centre"])
    axis, notch = "xyz"[first.mouth.normal], first.mouth.notch
    where = f"at the root of a notch {_number(notch)} deep in" if notch else "on"
    load = f"  axis: {axis}  # direction of the tension, which opens the notch\n" if axis != "z" else ""
    what = f"a strain of 0.1 % along {axis}; change it with load, magnitude and axis"
    if not first.loads_faces:
        what = f"a pressure on the crack faces, as no material touches both box faces normal to {axis}"
        load = "  load: none\n  lip_pressure: 100  # in the materials' unit\n"
    materials = "".join(f"  - {_yaml(one.text)}  # {one.about}\n" for one in first.materials)
    return f"""\
# A first campaign for {name}: {first.grains} grains, the median one {numbers["across"]} across.
# Lengths are in the file's units. Only keys that differ from the defaults are set; `craftmesh VERB --help`
# and config/config.yaml explain every key.
cases: {_yaml(sheet)}  # case table: case, microstructure, crack, increments
data: {_yaml(data)}  # folder of the microstructures in the case table

{section}sizing:  # edge lengths: l_min at the crack front, l0 at the distance r0, l_max from r1 on
  l_min: {numbers["l_min"]}  # {L_MIN:g} l0; half of it improves K with 8 times the elements at the front
  l0: {numbers["l0"]}  # the voxel's edge, or a quarter of a grain's diameter if that is smaller
  l_max: {numbers["l_max"]}  # at most 3 l0, with at least {ACROSS:g} elements across the median grain
  r0: {numbers["r0"]}
  r1: {numbers["r1"]}

cracks:
  notch:  # semicircular: the penny's centre lies {where} the face {first.mouth.face}
    shape: penny
    centre: [{centre}]
    normal: {first.crack["normal"]}  # it opens along {axis}
    radius: {_number(first.crack["radius"])}  # a quarter of the body's shortest edge, or less to fit
    growth: {_number(first.crack["growth"])}  # added in each further increment of the case table

inp:  # the input deck; its load is {what}
{load}  material:  # replace placeholders by the constants of your phases
{materials}
units:  # unit names for reports; add that of lengths, for example length: um
  stress: MPa
"""


def sheet_text(name: str, microstructure: str) -> str:
    """Return the case table of a first campaign: one case of one increment.

    microstructure: file name; it gets ./ in front where it would otherwise be read as YAML or as synthetic.
    """
    is_plain = re.match(r"\w", microstructure) and microstructure != SYNTHETIC
    text = io.StringIO()
    rows = csv.writer(text, delimiter="\t", lineterminator="\n")
    rows.writerow(["case", "microstructure", "crack", "increments"])
    rows.writerow([name, microstructure if is_plain else f"./{microstructure}", "notch", 1])
    return text.getvalue()


def _number(value: float, digits: int = 4) -> str:
    """Return a number as YAML 1.1 text: 1.0e-06, because YAML 1.1 reads 1e-06 as a string."""
    mantissa, exponent, power = f"{value:.{digits}g}".partition("e")
    return f"{mantissa}{'' if '.' in mantissa else '.0'}e{power}" if exponent else mantissa


def _yaml(value: Any) -> str:
    # JSON is valid YAML on one line, except for letters that JSON escapes as two \u
    return json.dumps(list(value) if isinstance(value, tuple) else value, ensure_ascii=False)

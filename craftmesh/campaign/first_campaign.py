"""A first configuration for a microstructure: sizes from its voxels and grains, a crack in a face."""

import csv
import io
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy import ndimage

from craftmesh.campaign.cases import SYNTHETIC
from craftmesh.io.file_volume import of_grains
from craftmesh.mechanics.crystals import known_material
from craftmesh.sizing.sizing import voxel_edge
from craftmesh.types import Crystal, Voxels
from craftmesh.voxels.mouth import Mouth, find_mouth
from craftmesh.voxels.voxel_graph import median_grain

# Eq. 3's default l_min, l0 / 2, makes three times the elements round the front; examples take 0.75 to 0.8.
L_MIN, L_MAX, R0 = 0.8, 3.0, 8.0  # over l0
ACROSS = 4.0  # elements across a grain at least: fewer leave the boundaries' curvature to chance
RADIUS = 0.25  # of the box's shortest edge across the crack; as much again is left beside its front
GROWTH = 0.25  # of the radius
_ABOUT = {"background": "  # what label 0 is: grain, void, or unindexed, which is filled from around it"}
OFF_CENTRE = 0.2  # of a voxel: planes between voxels are those in which flat grain boundaries lie


class FirstMaterial(NamedTuple):
    """A text of inp.material, what it is, and whether it stands in for a phase's own constants."""

    text: str
    about: str
    is_stand_in: bool


@dataclass(frozen=True)
class FirstCampaign:
    """The values of a first configuration, in model units, and what was seen of the microstructure.

    imported: the keys of the section import; sizing: l0, l_min, l_max, r0, r1; crack: centre, normal,
    radius and growth; mouth: where it begins; loads_faces: whether material is on the faces that the
    tension pulls at; materials: of inp.material; grains: how many; across: median diameter of a grain.
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
    """Return the first campaign for cleaned voxels; imported: how they were read and cleaned."""
    edge = voxel_edge(voxels)
    across = edge * float(np.cbrt(6 / np.pi * median_grain(voxels.labels)))
    (window,) = ndimage.find_objects((voxels.labels != 0).astype(np.int8))
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
    """Return a material for each phase: crystals where orientations are known, else isotropic."""
    grains = np.unique(voxels.labels[voxels.labels > 0])
    known = voxels.orientations is not None and np.isfinite(voxels.orientations[grains]).all()
    phases = np.unique(voxels.phases[grains]) if voxels.phases is not None else np.zeros(1, int)
    crystals = of_grains(voxels.crystals, voxels.phases)
    found = []
    for phase in phases.tolist():
        crystal = crystals.get(phase, Crystal())
        text, what, is_stand_in = known_material(crystal)
        if not known:
            text, what, is_stand_in = "isotropic:200000,0.3", "no orientations are read, so isotropic", True
        own = " ".join(" ".join(crystal).split()) or "unknown crystal"
        about = f"{what}, in MPa" + (f", a stand-in for phase {phase} ({own})" if is_stand_in else "")
        found.append(FirstMaterial(text if len(phases) < 2 else f"{phase}={text}", about, is_stand_in))
    return tuple(found)


def configuration_text(first: FirstCampaign, name: str, sheet: str, data: str) -> str:
    """Return the commented configuration of a first campaign, YAML for `snakemake --configfile`."""
    numbers = {key: _number(value) for key, value in ({**first.sizing, "across": first.across}).items()}
    imported = "".join(
        f"  {key}: {_yaml(value)}{_ABOUT.get(key, '')}\n" for key, value in first.imported.items()
    )
    section = f"import:  # how the file is read and cleaned\n{imported}\n" if imported else ""
    centre = ", ".join(_number(x, 6) for x in first.crack["centre"])
    axis, notch = "xyz"[first.mouth.normal], first.mouth.notch
    where = f"at the root of a notch {_number(notch)} deep in" if notch else "on"
    load = f"  axis: {axis}  # of the tension, which opens the notch\n" if axis != "z" else ""
    what = f"a strain of 0.1 % along {axis}, unless load, magnitude and axis say otherwise"
    if not first.loads_faces:
        what = f"a pressure on the lips: no material is on both faces of the box across {axis}, to pull at"
        load = "  load: none\n  lip_pressure: 100  # in the unit of the materials\n"
    materials = "".join(f"  - {_yaml(one.text)}  # {one.about}\n" for one in first.materials)
    return f"""\
# A first campaign for {name}: {first.grains} grains, the median one {numbers["across"]} across.
# Lengths are in the file's units. Only what differs from the defaults is named; `craftmesh VERB --help`
# and config/config.yaml explain every key.
cases: {_yaml(sheet)}  # the sheet: case, microstructure, crack, increments
data: {_yaml(data)}  # folder in which the sheet's microstructures lie

{section}sizing:  # edge lengths: l_min at the crack front, l0 at the distance r0, l_max from r1 on
  l_min: {numbers["l_min"]}  # {L_MIN:g} l0; halve it for K, and the front has eight times the elements
  l0: {numbers["l0"]}  # the voxel's edge, or a quarter of a grain where that is less
  l_max: {numbers["l_max"]}  # at most 3 l0, and {ACROSS:g} elements across the median grain
  r0: {numbers["r0"]}
  r1: {numbers["r1"]}

cracks:
  notch:  # semicircular: the centre of the penny lies {where} the face {first.mouth.face}
    shape: penny
    centre: [{centre}]
    normal: {first.crack["normal"]}  # it opens along {axis}
    radius: {_number(first.crack["radius"])}  # a quarter of the shortest edge of the body, or what fits
    growth: {_number(first.crack["growth"])}  # added at each increment that the sheet asks for

inp:  # the deck; its load is {what}
{load}  material:  # put the constants of your phases in place of stand-ins
{materials}
units:  # names beside the numbers that you read; add that of your lengths, as length: um
  stress: MPa
"""


def sheet_text(name: str, microstructure: str) -> str:
    """Return the sheet of a first campaign: one case of one increment.

    A file is ./FILE where its name alone would be a list of cases, or the synthetic volume.
    """
    is_plain = re.match(r"\w", microstructure) and microstructure != SYNTHETIC
    text = io.StringIO()
    rows = csv.writer(text, delimiter="\t", lineterminator="\n")
    rows.writerow(["case", "microstructure", "crack", "increments"])
    rows.writerow([name, microstructure if is_plain else f"./{microstructure}", "notch", 1])
    return text.getvalue()


def _number(value: float, digits: int = 4) -> str:
    """Return a number as YAML 1.1 has it, to which 1e-06 is text and 1.0e-06 a number."""
    mantissa, exponent, power = f"{value:.{digits}g}".partition("e")
    return f"{mantissa}{'' if '.' in mantissa else '.0'}e{power}" if exponent else mantissa


def _yaml(value: Any) -> str:
    # JSON is YAML on one line, but for letters written as two \u
    return json.dumps(list(value) if isinstance(value, tuple) else value, ensure_ascii=False)

"""The sizes of a campaign's increments before they are made: voxels, facets, elements."""

import json
from collections.abc import Collection, Iterator
from dataclasses import asdict, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from craftmesh.campaign.campaign import Campaign
from craftmesh.campaign.cases import SYNTHETIC, Case
from craftmesh.campaign.configuration import fields_of
from craftmesh.campaign.effort import Sizes, expected_elements, expected_facets
from craftmesh.commands.crack_sources import given_surface
from craftmesh.cracks.options import BY_NUMBERS, IN_BOUNDARIES, CrackOptions
from craftmesh.cracks.prescription import is_sized, semi_axes
from craftmesh.cracks.series import crack_of_increment
from craftmesh.growth.crack_size import share_of_size
from craftmesh.io.npz import read_labels
from craftmesh.sizing.sizing import Sizing, SizingOptions, densify, sizing_for, voxel_edge
from craftmesh.types import Crack, Voxels
from craftmesh.voxels.clean import clean
from craftmesh.voxels.clean_options import CleanOptions
from craftmesh.voxels.generate import GenerateOptions, generate
from craftmesh.voxels.raw_volume import as_raw
from craftmesh.voxels.reading import ReadOptions, read_voxels


def sizes_of(campaign: Campaign, cases: Collection[Case]) -> dict[str, dict[str, Sizes]]:
    """Return by case the sizes of each increment, of which the sheet knows the last at most.

    Cases that differ in nothing that sizes depend on are counted once.
    """
    sizes: dict[str, dict[str, Sizes]] = {}
    known: dict[str, dict[str, Sizes]] = {}
    for case in cases:
        made = Path(campaign.results) / case.name / "labels.npz"
        volume = [str(made)] if made.is_file() else _volume(case)
        asked = {key: case.settings[key] for key in ("cracks", "sizing", "stitch")}
        key = json.dumps([volume, asked, case.crack, case.increments, case.growth, case.settings["grow"]])
        if key not in known:
            voxels = read_labels(made) if made.is_file() else _filled(*volume)
            known[key] = dict(_sizes_by_increment(case, voxels))
        sizes[case.name] = known[key]
    return sizes


def _sizes_by_increment(case: Case, voxels: Voxels) -> Iterator[tuple[str, Sizes]]:
    facets = expected_facets(voxels)
    for inc in case.increment_names:
        elements = expected_elements(voxels, sizing_of_increment(case, voxels, int(inc)))
        yield inc, Sizes(voxels.labels.size, facets, elements)


def _volume(case: Case) -> list[str]:
    """Return what makes a case's volume, keys as JSON; seed 0 stands for all, whose sizes are alike."""
    section = "generate" if case.microstructure == SYNTHETIC else "import"
    keys = case.settings[section] | ({"seed": 0} if section == "generate" else {})
    return [case.microstructure, json.dumps(keys), json.dumps(case.settings["import"])]


@lru_cache(maxsize=1)  # the cases of a sweep follow one another
def _filled(microstructure: str, made: str, imported: str) -> Voxels:
    """Return the volume that a file and its keys, as JSON, make.

    Of the cleaning only the filling of voxels changes how much material there is.
    """
    keys = json.loads(imported)
    if microstructure == SYNTHETIC:
        volume = as_raw(generate(GenerateOptions(**json.loads(made))))
    else:
        read = ReadOptions(**fields_of(ReadOptions, keys))
        volume = read_voxels(microstructure, read, fills=keys["fill_unindexed"])
    if not volume.unindexed.any():
        return volume.voxels
    return clean(volume, CleanOptions(**fields_of(CleanOptions, keys)))[0]


def sizing_of_increment(case: Case, voxels: Voxels, increment: int) -> Sizing:
    """Return the sizing round the fronts of an increment, as far as they are known before it is solved.

    A crack that grows is taken as larger by a step at each increment; of a shape from files that grows,
    the first is taken; one along grain boundaries, which are not there yet, as a penny of its radius.
    """
    options = SizingOptions(**{**case.settings["sizing"], "field": None, "points": None, "curvature": None})
    if options.l0 is None:
        options = replace(options, l0=voxel_edge(voxels))
    sizing = sizing_for(None, options, np.zeros((0, 3)))
    sources = []
    for name in case.cracks:
        crack_options = CrackOptions(**case.settings["cracks"][name])
        if crack_options.shape == IN_BOUNDARIES:
            if not is_sized(crack_options):
                continue
            crack_options = _round(crack_options, increment)
        which = 0 if case.grows else increment
        if case.grows and crack_options.shape in BY_NUMBERS:
            share = case.settings["grow"]["share"] or share_of_size(case.settings["grow"]["change"])
            crack_options = _grown(crack_options, (1 + share) ** increment)
        if crack_options.shape in BY_NUMBERS:
            crack = _prescribed(json.dumps(asdict(crack_options)), which, *voxels.box.ravel().tolist())
        else:
            surface, _ = given_surface(crack_options, which, voxels.box, voxels)
            heights = case.settings["stitch"]["insertion"] == "cut"
            crack = crack_of_increment(crack_options, which, voxels.box, surface, heights)
        sources += [densify(crack.points[front], sizing.l_min / 2) for front in crack.fronts]
    return replace(sizing, sources=np.concatenate(sources)) if sources else sizing


@lru_cache(maxsize=64)  # one crack in many volumes of one size
def _prescribed(options: str, increment: int, *box: float) -> Crack:
    return crack_of_increment(CrackOptions(**json.loads(options)), increment, np.reshape(box, (2, 3)))


def _grown(options: CrackOptions, factor: float) -> CrackOptions:
    if options.semi_axes is not None:
        a, b = options.semi_axes
        return replace(options, semi_axes=(factor * a, factor * b))
    return replace(options, radius=None if options.radius is None else factor * options.radius)


def _round(options: CrackOptions, increment: int) -> CrackOptions:
    """Return a penny in place of a crack along grain boundaries."""
    radius, _ = semi_axes(options, increment)
    return CrackOptions(centre=options.centre, radius=radius)

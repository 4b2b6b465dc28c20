"""Write a first configuration for a microstructure: it runs, with a crack in the middle of a face."""

import argparse
import shlex
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path

import numpy as np

from craftmesh.atomic import atomic_paths
from craftmesh.campaign.campaign import read_campaign
from craftmesh.campaign.cases import RESERVED, as_case_name
from craftmesh.campaign.first_campaign import configuration_text, first_campaign, sheet_text
from craftmesh.campaign.paths import read_path
from craftmesh.campaign.workflow_location import read_config
from craftmesh.commands.flags import add_options, options_from
from craftmesh.errors import CraftmeshError, counted, existing, listed, named
from craftmesh.progress import ProgressLine
from craftmesh.types import VOID, Voxels
from craftmesh.voxels.background import ask_for_background, lies_in_specks, surrounds
from craftmesh.voxels.clean import ROUGH, clean
from craftmesh.voxels.options import CleanOptions
from craftmesh.voxels.reading import AUTO, ReadOptions, read_voxels
from craftmesh.voxels.remapping import RawVolume
from craftmesh.voxels.voxel_graph import dispersed, find_pieces, median_grain, speck_size

SMOOTHING_ROUNDS = 2  # smoothing rounds for rough boundaries, as the report of import advises


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("input", type=Path, help="microstructure file, or folder of TIFF slices")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help="configuration .yaml; the case table .tsv is written next to it (default NAME.yaml)",
    )
    add_options(parser, ReadOptions)


def run(arguments: argparse.Namespace) -> None:
    source = existing(arguments.input)
    name = as_case_name(source.stem).lstrip(".-") or "mine"
    name = f"{name}_case" if name.casefold() in RESERVED else name
    config = arguments.output or Path(f"{name}.yaml")
    if config.suffix.lower() not in (".yaml", ".yml"):
        raise CraftmeshError(
            f"--output is {config}; expected a configuration .yaml, its case table .tsv comes next to it"
        )
    sheet = config.with_suffix(".tsv")
    for path in (config, sheet):
        if path.exists():
            raise CraftmeshError(f"{path}: exists already; remove it, or choose another file with -o")
    read_path("the microstructure", str(source))
    raw = _read(source, options_from(arguments, ReadOptions))
    with ProgressLine("init") as progress:
        options, voxels, report = _cleaned(raw, progress)
    read = {f.name: getattr(arguments, f.name) for f in fields(ReadOptions) if hasattr(arguments, f.name)}
    cleaned = {f.name: getattr(options, f.name) for f in fields(CleanOptions)}
    defaults = {f.name: f.default for f in fields(CleanOptions)}
    read |= {"background": raw.background} if raw.background else {}
    imported = read | {key: value for key, value in cleaned.items() if value != defaults[key]}
    first = first_campaign(voxels, imported)
    text = configuration_text(first, source.name, str(sheet), str(source.parent))
    with atomic_paths([config, sheet]) as temporaries:
        for temporary, content in zip(temporaries, (text, sheet_text(name, source.name))):
            temporary.write_text(content, "utf-8")
        try:
            read_campaign(read_config(temporaries[0]) | {"cases": str(temporaries[1])})
        except CraftmeshError as error:
            raise CraftmeshError(f"{source}: its campaign would be rejected, {error}") from None
    shape = " x ".join(map(str, voxels.labels.shape))
    across = f"{first.across:.4g} across in the file's unit of length"
    print(f"{source}: {shape} voxels, grains: {first.grains}, the median one {across}")
    for change in report["changes"]:
        print(f"change: {change}")
    stand_ins = [f"inp.material {one.text}: {one.about}" for one in first.materials if one.is_stand_in]
    for note in [*report["notes"], *stand_ins]:
        print(f"note: {note}")
    print(f"wrote {config} and {sheet}; look them over, then")
    quoted = shlex.quote(str(config))
    print(f"  craftmesh plan {quoted}")
    print(f"  craftmesh run {quoted}")


def _read(source: Path, options: ReadOptions) -> RawVolume:
    """Return the volume of a file, with unindexed voxels around the sample taken as empty space.

    If they were filled from neighbours, the outer grains would grow. Raises CraftmeshError if unindexed
    voxels that do not surround the sample form connected components as large as the median grain, or
    components that span the box. With the option background, the volume is returned as it is read.
    """
    raw = read_voxels(source, options)
    labels = raw.voxels.labels
    if options.background != AUTO or not raw.unindexed.any():
        return raw
    pieces = find_pieces(labels)
    ends = [[np.take(pieces.of, end, axis=axis) for end in (0, -1)] for axis in range(3)]
    is_through = np.isin(np.arange(len(pieces.label)), [k for pair in ends for k in np.intersect1d(*pair)])
    is_large = pieces.voxels >= median_grain(labels)
    space = (pieces.label == 0) & (is_large | is_through)
    if not space.any() or lies_in_specks(pieces, speck_size(labels)):
        return raw
    if not surrounds(labels, pieces):
        with named(source):
            size = int(pieces.voxels[space].max())
            why = f"a component of {size} voxels is as large as the median grain, or spans the box"
            raise ask_for_background(labels, why)
    note = (
        f"label {options.background_value}, {counted(int(raw.unindexed.sum()), raw.unindexed.size)}, "
        "surrounds the rest and is taken as empty space; to fill it instead, set background to unindexed"
    )
    empty = read_voxels(source, replace(options, background=VOID))
    return replace(empty, background=VOID, notes=(*empty.notes, note))


def _cleaned(raw: RawVolume, progress: Callable[[float, str], None]) -> tuple[CleanOptions, Voxels, dict]:
    """Return the cleaning options that a volume needs, the voxels cleaned with them, and the report.

    Unindexed voxels are filled. Specks are absorbed if boundaries are rough or voxels were filled, and
    rough boundaries are smoothed, both only if this would not remove grains.
    """
    options = CleanOptions(fill_unindexed=bool(raw.unindexed.any()), allow_single_grain=True)
    voxels, report = clean(raw, options, progress)
    size = speck_size(voxels.labels)
    fine = dispersed(find_pieces(voxels.labels), size)
    fine = fine[fine > 0].tolist()
    is_rough = report["roughness"] > ROUGH
    if not fine and (is_rough or options.fill_unindexed):  # otherwise small grains are real, not noise
        options = replace(options, min_island_voxels=size)
    if not fine and is_rough:
        options = replace(options, smoothing_rounds=SMOOTHING_ROUNDS)
    one = len(np.unique(voxels.labels[voxels.labels > 0])) == 1
    options = replace(options, allow_single_grain=one)
    voxels, report = clean(raw, options, progress)
    if fine:
        report["notes"].append(
            f"most of grains {listed(fine)} lies in components under {size} voxels, which absorption or "
            "smoothing would remove: min_island_voxels and smoothing_rounds stay 0"
        )
    return options, voxels, report

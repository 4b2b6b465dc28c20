"""Write a first configuration for a microstructure: one that runs, with a crack in the middle of a face."""

import argparse
import re
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path

import numpy as np

from craftmesh.atomic import atomic_paths
from craftmesh.campaign.first_campaign import configuration_text, first_campaign, sheet_text, specks
from craftmesh.campaign.sheet import RESERVED
from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.stage_io import existing
from craftmesh.errors import CraftmeshError
from craftmesh.io.file_volume import VOID, listed
from craftmesh.progress import ProgressLine
from craftmesh.types import Voxels
from craftmesh.voxels.clean import ROUGH, clean
from craftmesh.voxels.clean_options import CleanOptions
from craftmesh.voxels.raw_volume import RawVolume
from craftmesh.voxels.reading import AUTO, ReadOptions, read_voxels

# Share of voxels without a grain over which they are empty space. Measured: AL1050 0.0008.
MUCH = 0.05
ROUNDS = 2  # of smoothing, where boundaries are rough: what the report of import advises


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("input", type=Path, help="microstructure file, or folder of TIFF slices")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help="configuration .yaml, the sheet of cases .tsv is written beside it (default NAME.yaml)",
    )
    add_options(parser, ReadOptions)


def run(arguments: argparse.Namespace) -> None:
    source = existing(arguments.input)
    name = re.sub(r"\W+", "_", source.stem).strip("_") or "mine"
    name = f"{name}_case" if name in RESERVED else name
    config = arguments.output or Path(f"{name}.yaml")
    sheet = config.with_suffix(".tsv")
    for path in (config, sheet):
        if path.exists():
            raise CraftmeshError(f"{path}: is there already; remove it, or name another file with -o")
    raw, background = _read(source, options_from(arguments, ReadOptions))
    with ProgressLine("init") as progress:
        options, voxels, report = _cleaned(raw, progress)
    read = {f.name: getattr(arguments, f.name) for f in fields(ReadOptions) if hasattr(arguments, f.name)}
    cleaned = {f.name: getattr(options, f.name) for f in fields(CleanOptions)}
    defaults = {f.name: f.default for f in fields(CleanOptions)}
    read |= {"background": background} if background else {}
    imported = read | {key: value for key, value in cleaned.items() if value != defaults[key]}
    first = first_campaign(voxels, imported)
    text = configuration_text(first, source.name, str(sheet), str(source.parent))
    with atomic_paths([config, sheet]) as temporaries:
        for temporary, content in zip(temporaries, (text, sheet_text(name, source.name))):
            temporary.write_text(content, "utf-8")
    shape = " x ".join(map(str, voxels.labels.shape))
    across = f"{first.across:.4g} across in the file's unit of length"
    print(f"{source}: {shape} voxels, grains: {first.grains}, the median one {across}")
    if background:
        print("note: label 0 fills so much that it is taken as empty space: import.background in the file")
    if report["absorbed_grains"]:
        print(f"note: grains {listed(report['absorbed_grains'])} are specks and go to their neighbours")
    for note in report["notes"]:
        print(f"note: {note}")
    print(f"wrote {config} and {sheet}; look them over, then")
    print(f"  craftmesh plan {config}")
    print(f"  snakemake -s $(craftmesh snakefile) --cores all --configfile {config}")


def _read(source: Path, options: ReadOptions) -> tuple[RawVolume, str]:
    """Return a volume, and what its label 0 is taken for in place of what the format says, if anything.

    Much without a grain is the space round a sample: filled, the grains at its faces would grow into it.
    """
    raw = read_voxels(source, options)
    if raw.unindexed.mean() <= MUCH or options.background != AUTO:
        return raw, ""
    return read_voxels(source, replace(options, background=VOID)), VOID


def _cleaned(raw: RawVolume, progress: Callable[[float, str], None]) -> tuple[CleanOptions, Voxels, dict]:
    """Return the cleaning that a volume needs, the cleaned voxels and the report."""
    options = CleanOptions(fill_unindexed=bool(raw.unindexed.any()), allow_single_grain=True)
    voxels, report = clean(raw, options, progress)
    is_rough = report["roughness"] > ROUGH
    if is_rough or options.fill_unindexed:  # as measured ones are; small grains of made ones are meant
        options = replace(options, min_island_voxels=specks(voxels.labels))
    if is_rough:
        options = replace(options, smoothing_rounds=ROUNDS)
    one = len(np.unique(voxels.labels[voxels.labels > 0])) == 1
    options = replace(options, allow_single_grain=one)
    voxels, report = clean(raw, options, progress)
    return options, voxels, report

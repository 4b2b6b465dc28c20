"""Grow a crack by one increment: its fronts go by the kink angles and extensions of sif.csv."""

import argparse
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from craftmesh.commands.crack import body_of
from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.stage_io import add_file, add_output, add_report, tell, warn
from craftmesh.cracks.severed import piece_cut_off
from craftmesh.cracks.within_box import area_within
from craftmesh.errors import CraftmeshError, existing
from craftmesh.growth.correct import Step, corrected
from craftmesh.growth.extension import CLOSED, NOISE, STAYS
from craftmesh.growth.grow import grow, row_spacing
from craftmesh.growth.moves import FrontExtensions
from craftmesh.growth.options import CorrectionOptions, SmoothingOptions
from craftmesh.growth.trust import Trust, trusted
from craftmesh.io.front_csv import front_table, write_front
from craftmesh.io.text_table import Table
from craftmesh.io.vtk import read_crack, write_crack
from craftmesh.types import Crack, Voxels

GOES = ("kink_angle", "extension")
RATES = ("rate", "power")
TRUSTED = "trusted"
FRAMES = tuple(f"{name}_{axis}" for name in ("normal", "binormal") for axis in "xyz")
LEFT = "every front has left the body"
STANDS = "no point of the front extends"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("crack", type=Path, help="crack surface .vtp")
    parser.add_argument("intensities", type=Path, help="sif.csv of that crack: kink angles and extensions")
    parser.add_argument("front", type=Path, help="front.csv of its mesh: the frames along the front")
    parser.add_argument(
        "--volume",
        type=Path,
        required=True,
        metavar="FILE",
        help="labels .npz, volume .vti or surface .vtp that gives the box",
    )
    add_output(parser, "grown crack surface .vtp")
    parser.add_argument(
        "--until",
        action="store_true",
        help="a crack that stops is no error: write it as it is, and why into the report as `ended`",
    )
    add_file(parser, "--base", "write the crack that the strip was joined to, a .vtp")
    add_file(parser, "--step", "write which way the strip went, node by node, a .csv")
    add_file(parser, "--last-base", "the crack that the strip before was joined to")
    add_file(parser, "--last-step", "which way it went: it is laid again, corrected")
    add_report(parser)
    add_options(parser, SmoothingOptions, CorrectionOptions)


def run(arguments: argparse.Namespace) -> None:
    crack = read_crack(existing(arguments.crack))
    box, _, voxels = body_of(arguments.volume)
    table = front_table(existing(arguments.intensities))
    along = front_extensions(table, front_table(existing(arguments.front)))
    words = table.words("stays") or []
    stays = {word: words.count(word) for word in STAYS if word in words}
    warn_of_short_steps(along, arguments.intensities)
    last = last_step(arguments) if options_from(arguments, CorrectionOptions).correct else None
    step = Step(crack, along, *rates_of(table))
    grown: Crack | None = crack
    if (along.extension > 0).any():
        step, grown = grown_step(
            step, last, box, options_from(arguments, SmoothingOptions), arguments.crack
        )
    if grown is None or not table.rows:
        ended = LEFT
    else:
        ended = standing(stays) if grown is crack else severed(voxels, grown)
    if ended and not arguments.until:
        raise CraftmeshError(
            f"{arguments.crack}: the crack stops here, {ended}; ask for no further increment of this case, "
            "or set its growth to until"
        )
    left = crack if grown is None or ended else grown
    write_crack(arguments.output, left)
    write_step(step, arguments)
    report = growth_report((crack, left), box, along, ended)
    tell(report | {"stays": stays, "corrected": turned(step, along)}, arguments.report)


def grown_step(
    step: Step, last: Step | None, box: np.ndarray, options: SmoothingOptions, crack: Path
) -> tuple[Step, Crack | None]:
    """Return the step that a crack takes and the grown crack, from where the last step ends corrected.

    Where that cannot be laid, or the crack cannot grow from there, a warning that names its file says so,
    and the step is as given.
    """
    if last is not None:
        try:
            better = corrected(last, step, box, options)
            return better, grow(better.crack, better.along, box, options)
        except CraftmeshError as error:
            warn(f"{crack}: its last strip stays as it is, not turned by the kinks at its end: {error}")
    return step, grow(step.crack, step.along, box, options)


def turned(step: Step, along: FrontExtensions) -> list[float]:
    """Return the least and largest turn of the strip behind a step that was to go `along`, degrees."""
    now = step.along.binormal
    angle = np.degrees(np.arctan2((now * along.normal).sum(axis=1), (now * along.binormal).sum(axis=1)))
    return _range(angle)


def warn_of_short_steps(along: FrontExtensions, intensities: Path) -> None:
    """Print a warning where points go on by less than the front's edges, in the median."""
    goes = along.extension > 0
    if not goes.any():
        return
    step, edge = float(np.median(along.extension[goes])), row_spacing(along.points)
    if step < edge:
        warn(
            f"{intensities}: the front goes on by {step:.4g}, and its edges are {edge:.4g} long; the next "
            "mesh cannot tell how it kinked: give a longer step (grow.extension, grow.change) or shorter "
            "edges (sizing.l_min)"
        )


def standing(stays: Mapping[str, int]) -> str:
    """Return in words that all points of a front stay, and why."""
    why = ", ".join(f"{count} {word} ({STAYS[word]})" for word, count in stays.items())
    return f"{STANDS}: {why}" if why else STANDS


def severed(voxels: Voxels | None, crack: Crack) -> str:
    """Return in words which piece of a body of voxels the crack cuts off, "" where it holds together."""
    # a body given by its surface has no voxels: the solver finds what is not held
    piece = None if voxels is None else piece_cut_off(voxels, crack)
    if piece is None:
        return ""
    place = ", ".join(f"{x:.4g}" for x in piece.middle)
    return f"the crack severs the body: a piece of volume {piece.volume:.4g} round ({place}) comes off"


def front_extensions(intensities: Table, front: Table) -> FrontExtensions:
    """Return where the points of a front go, by the nodes that sif.csv and front.csv both name.

    Those are trusted that steer by their flags (`trusted`), but for those that stay as K says nothing.
    Raises CraftmeshError for missing columns, bad numbers, and files of different meshes.
    """
    goes = _columns(intensities, ("node", *GOES), "made by `craftmesh fracture --crack`")
    frames = _columns(front, ("node", *FRAMES), "made by `craftmesh assemble --front-csv`")
    if not np.array_equal(goes["node"], frames["node"]):
        raise CraftmeshError(
            f"{intensities.path} and {front.path} name different nodes; expected the files of one mesh, "
            "row by row"
        )
    steers = trust_of(intensities, len(goes["node"])).steers
    says = ~np.isin(intensities.words("stays") or [""] * len(steers), (CLOSED, NOISE))
    angle = np.radians(goes["kink_angle"])
    return FrontExtensions(*_frames(frames), angle, goes["extension"], steers & says)


def trust_of(intensities: Table, count: int) -> Trust:
    """Return which of the `count` rows of a sif.csv steer; all rows do where it has no flags."""
    places = intensities.has(("front", "s")) and count
    front, s = intensities.numbers(("front", "s")).T if places else (None, None)
    return trusted(intensities.words("flags") or [""] * count, front, s)


def last_step(arguments: argparse.Namespace) -> Step | None:
    """Read what the crack grew from, None where the flags name no files.

    Raises CraftmeshError for one flag without the other, and as front_extensions does.
    """
    base, step = arguments.last_base, arguments.last_step
    if base is None and step is None:
        return None
    if base is None or step is None:
        raise CraftmeshError(
            "one of --last-base and --last-step is given alone; expected both, of the increment before"
        )
    table = front_table(existing(step))
    rows = _columns(table, (*FRAMES, *GOES, TRUSTED), "made by `craftmesh grow --step`")
    angle = np.radians(rows["kink_angle"])
    along = FrontExtensions(*_frames(rows), angle, rows["extension"], rows[TRUSTED] > 0)
    return Step(read_crack(existing(base)), along, *rates_of(table))


def rates_of(table: Table) -> tuple[np.ndarray | None, float]:
    """Return the columns of RATES as a Step has them; None and 0 where one of them is not there."""
    if not table.rows or not table.has(RATES):
        return None, 0.0
    rates = table.numbers(RATES)
    return rates[:, 0], float(np.median(rates[:, 1]))


def write_step(step: Step, arguments: argparse.Namespace) -> None:
    """Write what a crack grows from, as `last_step` reads it, where the flags name files."""
    if arguments.base:
        write_crack(arguments.base, step.crack)
    if arguments.step:
        along = step.along
        columns = {"points": along.points, "normal": along.normal, "binormal": along.binormal}
        columns |= {"kink_angle": np.degrees(along.kink_angle), "extension": along.extension}
        if step.rate is not None:
            columns |= {"rate": step.rate, "power": np.full(len(step.rate), step.power)}
        write_front(arguments.step, columns | {TRUSTED: along.trusted.astype(np.int64)})


def _frames(columns: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points, normals and binormals (n, 3) of a front's columns."""
    points, normal, binormal = (
        np.stack([columns[f"{name}{axis}"] for axis in "xyz"], axis=1)
        for name in ("", "normal_", "binormal_")
    )
    return points, normal, binormal


def _columns(table: Table, names: tuple[str, ...], made: str) -> dict[str, np.ndarray]:
    """Return x, y, z and other columns of numbers; raises CraftmeshError that says how they are made."""
    wanted = (*"xyz", *names)
    try:
        rows = table.numbers(wanted) if table.rows or not table.has(wanted) else np.zeros((0, len(wanted)))
    except CraftmeshError as error:
        raise CraftmeshError(f"{error}; expected a file {made}") from None
    return dict(zip(wanted, rows.T))


def growth_report(cracks: tuple[Crack, Crack], box: np.ndarray, along: FrontExtensions, ended: str) -> dict:
    """Return what of both cracks lies in the box, the ranges of extensions and kinks, and why it ended.

    Kink angles are in degrees, those of the points that go on.
    """
    angle = np.degrees(along.kink_angle)
    goes = along.extension > 0
    angle = angle[goes] if goes.any() else angle
    return {
        "area": [area_within(crack, box) for crack in cracks],
        "kink_angle": _range(angle),
        "extension": _range(along.extension),
        "fronts": len(cracks[1].fronts),
        "ended": ended,
    }


def _range(values: np.ndarray) -> list[float]:
    return [float(values.min()), float(values.max())] if len(values) else [0.0, 0.0]

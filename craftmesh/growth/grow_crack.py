"""Grow a crack by one increment by the columns of sif.csv, and find out why it stops."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from craftmesh.arguments import typed
from craftmesh.cracks.body_separation import piece_cut_off
from craftmesh.cracks.within_box import area_within
from craftmesh.errors import CraftmeshError
from craftmesh.growth.correct import corrected
from craftmesh.growth.extension import ENDS, STAYS, UNSTABLE, has_way
from craftmesh.growth.front_step import FrontStep, Step
from craftmesh.growth.grow import REPAIRS, GrownCrack, grow, row_spacing
from craftmesh.growth.options import SmoothingOptions
from craftmesh.growth.trust import trusted
from craftmesh.types import Crack, Surface, Voxels

LEFT = "every front has left the body"
STANDS = "no point of the front extends"


class Grown(NamedTuple):
    """The result of one increment.

    crack: the grown crack, or the given crack if growth ends; step: the step from which the new strip of
    crack surface was laid, with the extensions laid; ended: why growth ends, "" if it goes on;
    warnings: one line each.
    """

    crack: Crack
    step: Step
    ended: str
    warnings: tuple[str, ...]


@typed
def grow_crack(
    crack: Crack,
    body: Voxels | Surface,
    ways: Mapping[str, np.ndarray],
    frames: Mapping[str, np.ndarray],
    options: SmoothingOptions = SmoothingOptions(),  # noqa: B008 (frozen)
    last: Step | None = None,
) -> tuple[Grown, dict]:
    """Return the crack grown by one increment in a body, and a report.

    ways: the columns of sif.csv, as `front_extensions` returns them; frames: the columns of front.csv, as
    `front_frames(mesh).columns()` returns them. last: the previous step; its strip of crack surface is
    laid again by the kinks found at its end, or stays, with a warning, if that is not possible.
    Severing is detected only in a body of voxels. The report has areas before and after, ranges of kink
    angle, extension and correction (degrees), `laid`: the fraction of the extension laid, `ended`, and
    counts of points by their reason to stay. Raise CraftmeshError for missing columns, for columns of
    different meshes, and if the grown surface is no valid crack.
    """
    step = _step_of(crack, ways, frames)
    along, box, warnings = step.along, body.box, _short_step(step.along)
    grown: GrownCrack | None = None
    words = list(ways.get("stays", ()))
    stays = {word: words.count(word) for word in STAYS if word in words}
    if (along.extension > 0).any() and not stays.keys() & ENDS:
        try:
            better = step if last is None else corrected(last, step, box, options)
            grown, step = grow(better.crack, better.along, box, options), better
        except CraftmeshError as error:
            if last is None:
                raise
            warnings += [f"its last strip stays uncorrected for the kinks at its end: {error}"]
            grown = grow(crack, along, box, options)
    if not len(along.points) or (grown and grown.crack is None):
        ended = LEFT
    elif grown is None or grown.crack is None:
        why = ", ".join(f"{count} {word} ({STAYS[word]})" for word, count in stays.items())
        says = f"the crack is {UNSTABLE}" if UNSTABLE in stays else STANDS
        ended = f"{says}: {why}" if why else says
    else:
        ended = _severed(body, grown.crack)
    left, repairs, laid = crack, Counter[str](), 0.0
    if grown and grown.crack and not ended:
        left, repairs = grown.crack, grown.repairs
        laid = _fraction(grown.extension, step.along.extension)
        step = step._replace(along=replace(step.along, extension=grown.extension))
    now, goes = step.along.binormal, along.extension > 0
    turn = np.arctan2((now * along.normal).sum(axis=1), (now * along.binormal).sum(axis=1))
    report = {
        "area": [area_within(one, box) for one in (crack, left)],
        "kink_angle": _range(np.degrees(along.kink_angle[goes] if goes.any() else along.kink_angle)),
        "extension": _range(along.extension),
        "laid": laid,
        "fronts": len(left.fronts),
        "ended": ended,
        "stays": stays,
        "corrected": _range(np.degrees(turn)),
        "repairs": dict(repairs),
    }
    warnings += [f"{count} x {REPAIRS[name]}" for name, count in repairs.items()]
    if 0 < laid < 1:
        warnings += [f"the new surface is {laid:.3g} of the step long; the load cycles are of that length"]
    return Grown(left, step, ended, tuple(warnings)), report


def step_columns(step: Step) -> dict[str, np.ndarray]:
    """Return the columns of step.csv, from which `last_step` restores the step; kink angles in degrees."""
    along = step.along
    columns = {"points": along.points, "normal": along.normal, "binormal": along.binormal}
    columns |= {"kink_angle": np.degrees(along.kink_angle), "extension": along.extension}
    columns |= {"rate": along.rate, "power": along.power}
    return columns | {"trusted": along.trusted.astype(np.int64)}


def last_step(crack: Crack, columns: Mapping[str, np.ndarray]) -> Step:
    """Return the step of a crack, restored from the columns of step.csv (`step_columns`)."""
    return _step(crack, columns, columns, trusted=np.asarray(columns["trusted"]) > 0)


def _step_of(crack: Crack, ways: Mapping[str, np.ndarray], frames: Mapping[str, np.ndarray]) -> Step:
    """Return the step of a crack from the columns of sif.csv (`ways`) and front.csv (`frames`).

    A node is trusted if it steers by its flags (`trust.trusted`) and its K gives a direction (`has_way`).
    """
    missing = {"node", "kink_angle", "extension"} - ways.keys()
    missing |= {"node", "points", "normal", "binormal"} - frames.keys()
    if missing:
        raise CraftmeshError(
            f"no column {min(missing)}; give the columns of front_extensions and of front_frames"
        )
    if not np.array_equal(ways["node"], frames["node"]):
        raise CraftmeshError("sif.csv and front.csv name different nodes; give both files of one mesh")
    none = np.full(len(frames["node"]), "", object)
    places = {"front", "s"} <= ways.keys() and len(none)
    front, s = (ways["front"], ways["s"]) if places else (None, None)
    steers = trusted(ways.get("flags", none).tolist(), front, s).steers
    stays = np.asarray(ways.get("stays", none), object)
    return _step(crack, ways, frames, trusted=steers & has_way(stays), stays=stays)


def _step(
    crack: Crack,
    ways: Mapping[str, np.ndarray],
    frames: Mapping[str, np.ndarray],
    **known: np.ndarray,
) -> Step:
    """Return the step from columns (kink angles in degrees) and `known` fields of FrontStep.

    Without the columns rate and power, all points have the rate 1 and the power 0. The stretch is 0 where T
    is unknown and where the crack does not open.
    """
    if {"rate", "power"} <= ways.keys():
        known |= {name: ways[name] for name in ("rate", "power")}
    if {"K_I", "T"} <= ways.keys():
        opens = (ways["K_I"] > 0) & np.isfinite(ways["T"])
        known["stretch"] = np.where(opens, ways["T"], 0.0) / np.where(opens, ways["K_I"], 1.0)
    places = (frames[name] for name in ("points", "normal", "binormal"))
    kink, extension = np.radians(ways["kink_angle"]), ways["extension"]
    return Step(crack, FrontStep.of(*places, kink, extension, **known))


def _short_step(along: FrontStep) -> list[str]:
    """Return a warning if the median extension is shorter than the front's median edge, else no line."""
    goes = along.extension > 0
    if not goes.any():
        return []
    step, edge = float(np.median(along.extension[goes])), row_spacing(along.points)
    if step >= edge:
        return []
    return [
        f"the front extends by {step:.4g}, less than its edge length {edge:.4g}; the next mesh cannot "
        "resolve the kink: give a longer step (grow.extension, grow.change) or shorter edges (sizing.l_min)"
    ]


def _severed(body: Voxels | Surface, crack: Crack) -> str:
    """Return a sentence on the piece that the crack cuts off a body of voxels, else ""."""
    # A body given by its surface is not checked here: the solver finds severed pieces.
    piece = piece_cut_off(body, crack) if isinstance(body, Voxels) else None
    if piece is None:
        return ""
    place = ", ".join(f"{x:.4g}" for x in piece.middle)
    return f"the crack severs the body: a piece of volume {piece.volume:.4g} around ({place}) comes off"


def _fraction(laid: np.ndarray, extension: np.ndarray) -> float:
    """Return the median fraction of the extensions (n,) that was laid, at points that have moved."""
    goes = laid > 0
    return float(np.median(laid[goes] / extension[goes])) if goes.any() else 0.0


def _range(values: np.ndarray) -> list[float]:
    return [float(values.min()), float(values.max())] if len(values) else [0.0, 0.0]

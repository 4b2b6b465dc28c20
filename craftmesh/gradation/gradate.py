"""Gradation of a surface mesh to the sizing function (paper, sections 2.2-2.5), and its cleaning."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from craftmesh.arguments import typed
from craftmesh.cracks.crack_tolerances import GRADATED, PROMISED
from craftmesh.errors import CraftmeshError
from craftmesh.gradation.cleaning import clean_facets, split_ears
from craftmesh.gradation.crack_reference import HeldArea
from craftmesh.gradation.folds import short_beside_folds
from craftmesh.gradation.locality import spatially_sorted
from craftmesh.gradation.nonmanifold_vertices import release_tied_nodes
from craftmesh.gradation.passes import (
    Gradation,
    Limits,
    begun,
    collapse_short,
    even_lines,
    relax_all,
    split_long,
    swap_all,
    swap_poor,
)
from craftmesh.gradation.patch_reference import put_on_patches
from craftmesh.gradation.preprocess import remove_unnecessary_nodes, smooth_junctions
from craftmesh.gradation.report import figures_before, gradation_report
from craftmesh.gradation.state import surface_of
from craftmesh.options import Options, option
from craftmesh.progress import silent
from craftmesh.sizing.sizing import Sizing
from craftmesh.surface.check_surface import refuse_open
from craftmesh.surface.guarded_move import RESTORING
from craftmesh.surface.kernels.facet_shape import LEAST_ANGLE, score_of_angle
from craftmesh.surface.volumes import checked_targets, restore_volumes
from craftmesh.types import Crack, Surface

# Largest move of a vertex when volumes are restored, as a fraction of the distance tolerance. It is 1 if
# vertices have been put on given boundaries before; with 0.5 the volume of a coarse void was 3 % too small.
RESTORING_SHARE = 0.5
# Degrees: smallest angle of new facets (119 degrees has the same score), unless a replaced facet was worse.
# With 15 (and 135) degrees, where grains are small relative to the target lengths, three in four of the
# tetrahedra with an aspect ratio over 5 were at facets with angles under 25 or over 120 degrees. With 20
# degrees a third of these tetrahedra remain, and the surface there has a tenth more facets.
SOUND_ANGLE = 20.0
# Fractions of the distance tolerances of crack and front, tried in turn until the crack's area is within
# its allowed error. With the full tolerances a crack of 4 l_min^2 with a crease of 49 degrees lost 1.4 % of
# its area, and one of 7 l_min^2 whose mouth grazes a face lost 1.6 %. A quarter of the tolerances reduced
# the first loss to 0.1 %, an eighth the second to 0.8 %. Smaller fractions make poorer facets.
CRACK_SHARES = 1 / 2 ** np.arange(4)


@dataclass(frozen=True)
class GradateOptions(Options):
    """Options of the stage `gradate`: tolerances to the input surface, rounds, and optional steps."""

    normal_tolerance: float = option(
        40.0, "largest turn of a facet's normal from the input's", "degrees", above=0, below=90
    )
    distance_tolerance: float = option(
        0.15, "largest distance of input vertices over the target length", at_least=0
    )
    crack_tolerance: float = option(GRADATED, "the same on the crack, over l_min", at_least=0)
    volume_tolerance: float = option(0.02, "largest relative change of a grain's volume", at_least=0)
    collapse_ratio: float = option(
        0.75, "edges under this ratio to their target are collapsed", at_least=0, below=1
    )
    split_ratio: float = option(
        1.4, "edges over this ratio to their target are split, none longer is made than there was", above=1
    )
    passes: int = option(4, "rounds of collapse, swap and split", at_least=0)
    cleaning_passes: int = option(8, "rounds of needle and cap removal after the gradation", at_least=0)
    cleaning_angle: float = option(
        30.0, "angle towards which the cleaning raises the facets", "degrees", at_least=0, at_most=60
    )
    remove_unnecessary_nodes: bool = option(True, "first remove vertices of three facets (section 2.2)")
    release_tied_nodes: bool = option(False, "first part sheets that meet in single vertices (section 2.2)")
    restore_volumes: bool = option(True, "bring the grains' volumes back at the end")
    junction_smoothing: int = option(
        0, "iterations of sawtooth smoothing of junctions first (Eq. 1)", at_least=0
    )


@typed
def gradate(
    surface: Surface,
    sizing: Sizing,
    options: GradateOptions | None = None,
    progress: Callable[[float, str], None] = silent,
    volumes: Mapping[int, float] | None = None,
    crack: Crack | None = None,
    boundaries: Surface | None = None,
) -> tuple[Surface, dict]:
    """Return `surface` with edges of the lengths in `sizing`, and a report.

    volumes: target volumes of grains k and voids -k for options.restore_volumes instead of the volumes in
    `surface`. crack: the given crack, onto which vertices of the crack and its front are projected and to
    which crack facets stay close; without it, crack and front of `surface` have this role. boundaries: a
    surface onto whose grain boundaries and voids the vertices of the same labels are moved at the end.

    Junction lines, box planes, crack and front keep their topology and, within the tolerances, their
    place. Every grain stays closed and keeps its topology, and no step makes facets intersect. The
    report (`gradation_report`) has counts of operations and refusals, ratios of edge length to target,
    angles, relative volume changes, and numbers of facets and wedges (dihedral angles of a grain) under
    12 degrees. Raises CraftmeshError for a surface without facets, for grains that are open or inside
    out, and for volumes of labels that the surface does not have.
    """
    options = options or GradateOptions()
    if not len(surface.facets):
        raise CraftmeshError("the surface has no facets; expected at least one to gradate")
    progress(0.0, "preprocess")
    surface = spatially_sorted(surface)
    before = figures_before(surface, refuse_open(surface))
    checked_targets(volumes or {}, surface)
    held = HeldArea(surface, crack, sizing.l_min)
    surface, done = _prepared(surface, options)
    sizing = short_beside_folds(surface, sizing)
    least = np.inf
    for share in CRACK_SHARES:
        limits = _limits(options, sizing, crack, share)
        attempt = _gradated(begun(surface, sizing, crack, done), sizing, limits, options, progress)
        found = surface_of(attempt.state, surface)
        times = held.times_off(found)
        if times <= 1 or times < least:
            gradation, result, least = attempt, found, times
        if times <= 1:
            break
    share = RESTORING_SHARE
    if boundaries is not None:
        result, share = put_on_patches(result, boundaries, sizing), 1.0
    if options.restore_volumes:
        progress((options.passes + 1) / (options.passes + 2), "volumes")
        result = _restored(
            result, before.volumes | dict(volumes or {}), sizing, share * options.distance_tolerance
        )
    progress(1.0, "done")
    return result, gradation_report(gradation, before, result, sizing)


def _prepared(surface: Surface, options: GradateOptions) -> tuple[Surface, dict[str, int]]:
    """Return the preprocessed surface in spatial order, and the numbers of changed nodes.

    The numbers have the keys released_nodes, unnecessary_nodes and smoothed_nodes.
    """
    released, removed = 0, 0
    if options.release_tied_nodes:
        surface, released, _ = release_tied_nodes(surface)
    if options.remove_unnecessary_nodes:
        surface, removed = remove_unnecessary_nodes(surface, options.normal_tolerance)
    surface, smoothed = smooth_junctions(surface, options.junction_smoothing)
    done = {"released_nodes": released, "unnecessary_nodes": removed, "smoothed_nodes": smoothed}
    return spatially_sorted(surface) if any(done.values()) else surface, done


def _gradated(
    gradation: Gradation,
    sizing: Sizing,
    limits: Limits,
    options: GradateOptions,
    progress: Callable[[float, str], None],
) -> Gradation:
    """Change `gradation` by options.passes rounds and a final cleaning of poor facets, and return it.

    Long edges are split before the rounds, whatever the shape of their halves: thin facets have only poor
    halves, for example on a drawn cylinder or between the front and the middle of a crack. A round
    collapses, splits and swaps edges, and makes the spacing along lines equal. From half of the rounds on,
    vertices inside patches also move towards equal spacing. Volumes are not restored here.
    """
    if options.passes:
        swap_poor(gradation, limits)
    any_shape = limits._replace(floor=0.0)
    while options.passes and split_long(gradation, any_shape):
        swap_poor(gradation, limits)
        gradation.set_sizes(sizing)
    for n in range(options.passes):
        progress(n / (options.passes + 2), f"gradate, round {n + 1} of {options.passes}")
        gradation.set_sizes(sizing)
        collapse_short(gradation, limits)
        gradation.set_sizes(sizing)
        split_long(gradation, limits)
        swap_all(gradation, limits)
        even_lines(gradation, limits)
        if n >= options.passes // 2:
            relax_all(gradation, limits)
            swap_all(gradation, limits)
    progress(options.passes / (options.passes + 2), "clean")
    clean_facets(gradation, sizing, limits, options.cleaning_passes, options.cleaning_angle)
    split_ears(gradation, limits)
    return gradation


def _restored(result: Surface, targets: Mapping[int, float], sizing: Sizing, reach: float) -> Surface:
    """Return `result` with its volumes moved towards `targets`, as far as moves are allowed.

    Targets <= 0, and of labels without facets, are ignored. reach: largest move of a vertex in target
    lengths.
    """
    present = set(np.unique(result.sides).tolist())
    targets = {k: v for k, v in targets.items() if v > 0 and k in present}
    if not targets:
        return result
    return restore_volumes(result, targets, RESTORING, reach=reach * sizing.at(result.points))[0]


def _limits(options: GradateOptions, sizing: Sizing, crack: Crack | None, share: float) -> Limits:
    facets = np.inf if crack is None else max(options.crack_tolerance, GRADATED)
    unit = share * sizing.l_min
    return Limits(
        collapse=float(options.collapse_ratio),
        split=float(options.split_ratio),
        longest=float(options.split_ratio),
        floor=score_of_angle(SOUND_ANGLE),
        # with SOUND_ANGLE as floor, one front edge in ten would differ from l_min by more than a tenth;
        # the cleaning raises the small angles that the lower floor allows
        even_floor=score_of_angle(LEAST_ANGLE),
        gain=0.0,
        cosine=float(np.cos(np.radians(options.normal_tolerance))),
        distance=float(options.distance_tolerance),
        crack_distance=float(options.crack_tolerance * unit),
        front_distance=min(options.crack_tolerance, PROMISED.front) * unit,
        crack_facets=facets * unit,
        drift=float(options.volume_tolerance),
        merge_points=False,
    )

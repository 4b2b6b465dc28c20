"""Insert a crack into a conformal surface: cut along it, triangulate it, find its grains."""

from collections.abc import Callable

import numpy as np

from craftmesh.arguments import typed
from craftmesh.cracks.near_faces import refuse_near_faces
from craftmesh.cracks.sheets import by_place, heights_of, seam_ends
from craftmesh.errors import CraftmeshError, rounded_values
from craftmesh.insertion.attempts import (
    Fronts,
    Given,
    Inserted,
    fronts_of,
    misfit_of_fronts,
    moved,
    refuse_gross,
    soundest,
    unmoved,
)
from craftmesh.insertion.crack_patch import labels_of_patch, with_patch
from craftmesh.insertion.cut import CutSurface, SizeAt, cut_along, flat_facets, with_phi
from craftmesh.insertion.front_chain import FrontChain, chain, conflicts, without_loose_ends
from craftmesh.insertion.intergranular_crack import inlaid
from craftmesh.insertion.options import InsertOptions
from craftmesh.insertion.pierce import at_corners, pierce, settle_front, snap_to_front
from craftmesh.insertion.sheet import Sheet, sheet_of
from craftmesh.insertion.snap import local_sizes, prepared, snap_to_crack, taken_at_box_edges
from craftmesh.insertion.traces import follow_traces, inside_traces, settle_chords
from craftmesh.progress import silent
from craftmesh.sizing.sizing import Lengths, Sizing
from craftmesh.surface.check_surface import refuse_open
from craftmesh.surface.connectivity import compact, rows_among
from craftmesh.surface.measure import area_vectors, total_area
from craftmesh.surface.patches import is_on_box
from craftmesh.types import CRACK, INTERFACE, Crack, Surface

HALVINGS = 10  # most bisections of the edges between two pierce points, until the front crosses no trace
# Numbers of the report that are summed over the parts of a crack.
COUNTED = (
    "crack_facets_outside_material",
    "crack_facets_on_grain_boundaries",
    "boundary_points_moved",
    "boundary_facets_moved",
)


@typed
def insert_crack(
    surface: Surface,
    crack: Crack,
    sizing: Lengths | None = None,
    options: InsertOptions | None = None,
    progress: Callable[[float, str], None] = silent,
    known: np.ndarray | None = None,
) -> tuple[Surface, dict[str, int | float]]:
    """Return the surface with the crack's facets (kind CRACK), conformal at grain boundaries, and a report.

    surface: one that passes `check_surface`, from craftmesh or from `Surface.of_facets`; the body need not
    fill its box. crack: from any source, in the same box (`crack_from_triangles`). Its parts outside the
    body are dropped, and several surfaces are inserted one after another. sizing.at(points) returns target
    lengths of front edges; None: the surface's median edge length. Crack facets are as large as the crack's
    shape allows; the gradation refines them. known (k, 3): points of the surface that lie on the crack as
    an older mesh has it; they stay where they are. Grain boundaries keep their shape except at points that
    move onto the crack (options.snap). Raise CraftmeshError if grains are open or inside out, if the crack
    meets no grain, if its traces cannot be triangulated, or if its facets would intersect others, as those
    of a curved crack along a box plane.
    """
    refuse_open(surface)
    options = options or InsertOptions()
    target = target_of(surface, sizing)
    reports = []
    box, before = surface.box, surface
    for sheet in by_place(crack):
        inlay = inlaid(surface, sheet)
        if inlay is not None:
            surface = inlay
            numbers = numbers_of(surface, 0) | unmoved(len(sheet.triangles)) | {"crack_off_times": 0.0}
            reports.append(numbers)
            continue
        least = least_length(_ends(sheet, box), target, sizing)
        refuse_near_faces(sheet, box, least)
        parts = heights_of(sheet, box)
        held = seam_ends(parts)
        for part in parts:
            given = Given(part, box, least, held)
            surface, numbers = _with_part(surface, given, target, options, known, progress)
            reports.append(numbers)
        if len(parts) > 1:
            fronts = fronts_of(before, crack)
            reports[-1] = _as_one(surface, fronts, least, reports[-1])
    progress(1.0, "done")
    return surface, _total(reports)


def _total(reports: list[dict[str, int | float]]) -> dict[str, int | float]:
    """Return the report of all parts of a crack.

    Areas and counts are the last part's, which cover the whole surface; the numbers in COUNTED are sums,
    the largest moves and deviations maxima over the parts.
    """
    total = dict(reports[-1])
    for name in COUNTED:
        total[name] = sum(numbers[name] for numbers in reports)
    for name in ("boundary_moved_most", "crack_moved_most", "crack_off_times"):
        total[name] = max(numbers[name] for numbers in reports)
    return total


def _as_one(
    surface: Surface, fronts: Fronts, least: float, last: dict[str, int | float]
) -> dict[str, int | float]:
    """Return the last part's report with the numbers of the whole crack surface, all parts inserted.

    least: smallest target length. Raise CraftmeshError if the front is farther from the given fronts than
    GROSS times the promise.
    """
    off = misfit_of_fronts(surface, fronts, least)
    refuse_gross(off)
    numbers = numbers_of(surface, int(last["crack_facets_outside_material"]))
    return last | numbers | {"crack_off_times": max(off.promised, last["crack_off_times"])}


def _with_part(
    surface: Surface,
    given: Given,
    target: SizeAt,
    options: InsertOptions,
    known: np.ndarray | None,
    progress: Callable[[float, str], None],
) -> tuple[Surface, dict[str, int | float]]:
    """Return the surface with one part of a crack inserted, and the report of that part.

    known (k, 3): points of an older mesh's crack in the surface, which stay; target: target lengths at
    points.
    """
    sheet, least = sheet_of(given.crack, surface.box, given.held), given.least
    best = soundest(
        prepared(surface, sheet, known, least),
        sheet,
        given,
        options,
        lambda cut, chosen: _inserted(cut, sheet, target, least, chosen, progress),
    )
    numbers = best.made.numbers | moved(best.cut, best.made.surface, sheet, least)
    numbers["crack_off_times"] = best.off.promised
    return best.made.surface, numbers


def _inserted(
    cut: CutSurface,
    sheet: Sheet,
    target: SizeAt,
    least: float,
    options: InsertOptions,
    progress: Callable[[float, str], None],
) -> Inserted:
    """Return the surface with the crack inserted; its facets may still intersect others."""
    progress(0.0, "cut")
    cut = taken_at_box_edges(snap_to_crack(cut, sheet, options), sheet, least)
    cut = with_phi(cut_along(cut, sheet), sheet)
    if sheet.planar:
        cut = at_corners(cut, sheet)
    else:
        cut = with_phi(follow_traces(cut, sheet, least, options), sheet)
    progress(0.3, "front")
    cut = snap_to_front(cut, sheet, target, options)
    cut = pierce(cut, sheet)
    cut = settle_front(cut, sheet, options)
    if not sheet.planar:
        cut = settle_front(pierce(follow_traces(cut, sheet, least, options), sheet), sheet, options)
    cut, along = settle_chords(cut, sheet, target, options)
    front, traces = _front_and_traces(cut, sheet, along, target)
    progress(0.5, "crack facets")
    cut, triangles, fixed = with_patch(cut, sheet, front, traces, least)
    progress(0.8, "grains")
    return _assembled(cut, sheet, triangles, fixed)


def target_of(surface: Surface, sizing: Lengths | None) -> SizeAt:
    """Return target lengths as a function of points: the sizing's, or the surface's median edge length."""
    if sizing is None:
        uniform = float(np.median(local_sizes(surface)[0]))
        return lambda points: np.full(len(points), uniform)
    return sizing.at


def _ends(sheet: Crack, box: np.ndarray) -> np.ndarray:
    """Return the points (n, 3) of a crack's fronts; without fronts its points in the box, or else all."""
    if sheet.fronts:
        ends: np.ndarray = sheet.points[np.concatenate(sheet.fronts)]
        return ends
    inside = ((sheet.points >= box[0]) & (sheet.points <= box[1])).all(axis=1)
    return sheet.points[inside] if inside.any() else sheet.points


def least_length(ends: np.ndarray, target: SizeAt, sizing: Lengths | None) -> float:
    """Return the length that a crack's tolerances refer to: l_min, or the smallest target at `ends` (n, 3).

    l_min is used because the targets of a `Sizing` may be far longer if the crack's front lies outside the
    box.
    """
    return sizing.l_min if isinstance(sizing, Sizing) else float(target(ends).min())


def _front_and_traces(
    cut: CutSurface, sheet: Sheet, along: np.ndarray, target: SizeAt
) -> tuple[FrontChain, np.ndarray]:
    """Return the front chain, refined until its edges cross no trace, and the traces (k, 2) inside it."""
    traces, _ = inside_traces(cut)
    crowd = np.zeros(0, np.int64)
    for _ in range(HALVINGS):
        front = chain(cut, sheet, along, target, crowd)
        uv = np.concatenate([sheet.uv(cut.points), front.uv])
        bad = conflicts(front.edges, traces, uv)
        if not len(bad):
            return without_loose_ends(front, traces), traces
        crowd = np.pad(crowd, (0, int(front.edges[:, 2].max()) + 1 - len(crowd)))
        crowd[bad] += 1
    position = uv[front.edges[front.edges[:, 2] == bad[0]][0, 0]]
    raise CraftmeshError(
        f"the crack front near {rounded_values(sheet.lift(position[None])[0])} runs too close along a "
        f"grain boundary "
        "to be meshed; move the crack a little"
    )


def _assembled(cut: CutSurface, sheet: Sheet, triangles: np.ndarray, fixed: np.ndarray) -> Inserted:
    """Return the surface with the crack facets added and marked.

    Facets of grain boundaries that lie on the crack become crack facets. Facets of voids and of the box
    that lie on it stay, because they are free already.
    """
    kind, sides, facets = cut.kind.copy(), cut.sides.copy(), cut.facets.copy()
    flat = flat_facets(cut)
    same = rows_among(facets[flat], triangles)
    covered = np.isin(np.arange(len(triangles)), same)
    flat = flat[same >= 0]
    between = (kind[flat] == INTERFACE) & (sides[flat] > 0).all(axis=1)
    free, flat = flat[~between], flat[between]
    turned = area_vectors(cut.points, facets[flat]) @ sheet.frame[2] < 0
    facets[flat[turned]] = facets[flat[turned]][:, ::-1]
    sides[flat[turned]] = sides[flat[turned]][:, ::-1]
    kind[flat] = CRACK
    own = np.zeros(len(facets), bool)
    own[flat] = True
    label = labels_of_patch(cut.points, triangles, fixed, cut.facets, cut.sides)
    keep = (label > 0) & ~covered
    if not keep.any() and not len(flat):
        raise CraftmeshError("the crack lies in no grain; move it into the material")
    facets = np.concatenate([facets, triangles[keep].astype(np.int32)])
    sides = np.concatenate([sides, np.stack([label[keep]] * 2, axis=1)])
    kind = np.concatenate([kind, np.full(int(keep.sum()), CRACK)])
    points, facets, kept = compact(cut.points, facets)
    result = Surface(points, facets, sides, kind)
    own = np.concatenate([own, np.ones(int(keep.sum()), bool)])
    in_voids = [triangles[(label < 0) & ~covered], cut.facets[free[~is_on_box(cut.kind[free])]]]
    hidden = total_area(cut.points, np.concatenate(in_voids))
    numbers = numbers_of(result, int(((label <= 0) & ~covered).sum()) + len(free))
    return Inserted(result, own, hidden, numbers)


def numbers_of(surface: Surface, dropped: int) -> dict[str, int | float]:
    """Return the report's numbers on the crack facets; dropped: number of facets outside the material."""
    crack = surface.kind == CRACK
    area = total_area(surface.points, surface.facets[crack])
    return {
        "crack_facets": int(crack.sum()),
        "crack_facets_outside_material": dropped,
        "crack_area": area,
        "crack_grains": int(len(np.unique(surface.sides[crack]))),
    }

"""The voxel way: a crack's facets are those of marching cubes between labels split on either side of it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from craftmesh.cracks.split_voxels import SplitVoxels
from craftmesh.errors import CraftmeshError, told
from craftmesh.insertion.clip import clipped, halved_facets, halved_fronts
from craftmesh.insertion.contract import contracted, without_caps
from craftmesh.insertion.cut import CutSurface, uncut
from craftmesh.insertion.insert import insert_crack, least_length, numbers_of, target_of
from craftmesh.insertion.misfit import FACETS_OFF, FRONT_OFF
from craftmesh.insertion.onto_kinks import onto_kinks
from craftmesh.insertion.onto_sheets import onto_sheets
from craftmesh.insertion.options import InsertOptions
from craftmesh.insertion.snap import local_sizes
from craftmesh.mesh.flat_tets import FLAT_DIHEDRALS
from craftmesh.progress import silent
from craftmesh.sizing.sizing import Lengths
from craftmesh.surface.connectivity import compact, unique_edges
from craftmesh.surface.front import front_edges
from craftmesh.surface.measure import side_volumes
from craftmesh.surface.patches import feature_edges
from craftmesh.surface.volumes import RestoringLimits, restore_volumes
from craftmesh.surface.wedges import sharp_wedges
from craftmesh.types import CRACK, Crack, Surface

# Of the least length: the least width of a strip between the crack's front and another line. No operation
# of the gradation closes a strip. On the crack 0.004 left a deck with 2 flat tetrahedra, 0.03 facets of 6
# degrees; of 19 other random cracks the narrowest were 0.053, with facets of 6 too, and 0.11. Past the
# front, on a grain boundary, 0.001 left a flat one; of 24 others the narrowest were 0.049 and 0.052.
NARROW = 0.05


def fault_of(surface: Surface, report: dict, least: float) -> str | None:
    """Return why a crack by voxels had better be cut: off the given one, in a flat wedge, a narrow strip.

    report: of insert_split. least: the least target length on the crack's fronts.
    """
    off = {name: report[name] / least for name in ("crack_off_most", "front_off_most")}
    if off["crack_off_most"] > FACETS_OFF or off["front_off_most"] > FRONT_OFF:
        return (
            f"voxels leave the crack {off['crack_off_most']:.2g} l_min off the given one and its front "
            f"{off['front_off_most']:.2g}; expected {FACETS_OFF} and {FRONT_OFF} at most"
        )
    wedges = sharp_wedges(surface)
    flattest = wedges.angle[(surface.kind[wedges.facets] == CRACK).any(axis=1)].min(initial=180.0)
    if flattest < FLAT_DIHEDRALS[0]:
        return (
            f"voxels leave a wedge of {flattest:.2g} degrees between the crack and what is beside it; "
            f"expected {FLAT_DIHEDRALS[0]:g} at least"
        )
    width = narrowest_strip(surface) / least
    if width < NARROW:
        return (
            f"voxels leave a strip {width:.2g} l_min wide between the crack's front and another line; "
            f"expected {NARROW} at least"
        )
    return None


def narrowest_strip(surface: Surface) -> float:
    """Return the length of the shortest edge across a patch from the front to another line, or infinity.

    Lines are junction lines, traces of grain boundaries and mouths among them.
    """
    edges, _, _, is_line = feature_edges(surface)
    on_front, on_line = np.zeros((2, len(surface.points)), bool)
    on_front[front_edges(surface)] = True
    on_line[edges[is_line]] = True
    first, second = edges.T
    crosses = ~is_line & on_line[first] & on_line[second] & (on_front[first] != on_front[second])
    ends = surface.points[edges[crosses]]
    return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).min(initial=np.inf))


OFF = 0.25  # of the least length: notches were 0.77 off, corners between two discs 0.1
ROUNDS = 5  # of moving points onto the crack and closing what is in their way
# Degrees beside the way of a point that cannot move: edges to points there are closed too. No one serves
# all, so the next is tried where points are left. Two random cracks 0.18 l_min off with the first came in
# with the second or the third; one that the first serves stayed 0.37 off with the second.
CLOSINGS = (0.0, 75.0, 181.0)
LEAST_QUALITY = 0.05  # of facets that the restored volumes may leave; the clip makes some of 0.1


def insert_by_voxels(
    surface: Surface,
    crack: Crack,
    halves: tuple[Surface, np.ndarray],
    split: SplitVoxels,
    sizing: Lengths | None = None,
    options: InsertOptions | None = None,
    progress: Callable[[float, str], None] = silent,
) -> tuple[Surface, dict]:
    """Return the surface with a crack in it as voxels part the grains, or cut where these are too coarse.

    surface: of the volume without a crack; halves: surface and bits of `remesh_split` for the volume
    `split` along `crack`. Cut are cracks that voxels refuse, or bring in with a fault, if they can be
    (voxel_faults); the report's cut_instead says why.
    Raises CraftmeshError as insert_split.
    """
    found = None
    try:
        found = insert_split(*halves, split, sizing, options)
        why = fault_of(*found, least_length(_ends(split), target_of(halves[0], sizing), sizing))
        if why is None:
            return found
    except CraftmeshError as error:
        why = str(error)
    try:
        result, report = insert_crack(surface, crack, sizing, options, progress)
    except CraftmeshError:
        if found is None:
            raise CraftmeshError(why) from None
        return found
    return result, report | {"cut_instead": why}


def insert_split(
    surface: Surface,
    bits: np.ndarray,
    split: SplitVoxels,
    sizing: Lengths | None = None,
    options: InsertOptions | None = None,
) -> tuple[Surface, dict]:
    """Return the surface of a split volume with its crack facets on the crack and clipped at its fronts.

    surface, bits (m,): from `remesh_split` for the volume `split`. sizing.at(points) gives the lengths of
    front edges; None: the surface's median edge length. The grains' volumes stay those of `surface`.
    Raises CraftmeshError where nothing of the crack lies in a grain, and where it lies off the given one or
    ends off its fronts, as where voxels leave a notch in its mouth.
    """
    options = options or InsertOptions()
    target = target_of(surface, sizing)
    least = least_length(_ends(split), target, sizing)
    cut = _with_bits(surface, bits)
    cut = _on_crack(cut, split, options)
    for number, look in enumerate(split.sheets):
        cut = clipped(cut, number, look, options)
        cut = halved_fronts(cut, look, target, options)
        cut = onto_kinks(cut, number, look, options)
        cut = halved_facets(cut, number, look, least, options)
    if not (cut.kind >= CRACK).any():
        raise CraftmeshError("the crack lies in no grain; expected a crack within the material: move it")
    cut = without_caps(cut)
    points, facets, _ = compact(cut.points, cut.facets)
    result = Surface(points, facets, cut.sides, np.minimum(cut.kind, CRACK))
    volumes = side_volumes(surface.points, surface.facets, surface.sides)
    volumes = {label: volume for label, volume in volumes.items() if label > 0}
    result, report = restore_volumes(result, volumes, RestoringLimits(min_quality=LEAST_QUALITY))
    return result, numbers_of(result, 0) | {"volumes": report} | _off_most(result, split, least)


def _ends(split: SplitVoxels) -> np.ndarray:
    """Return the points (n, 3) of the sheets' fronts, all of sheets without one."""
    ends = [look.points[look.fronts.ravel()] if len(look.fronts) else look.points for look in split.sheets]
    return np.concatenate(ends)


def _on_crack(cut: CutSurface, split: SplitVoxels, options: InsertOptions) -> CutSurface:
    """Return the surface with the crack's points on it, those inside its fronts as near as they will go."""
    nowhere = np.zeros(0, np.int64), np.zeros((0, 3))
    begun = onto_sheets(contracted(cut, *nowhere), split.sheets, options)
    best, least = begun[0], np.inf
    for ahead in CLOSINGS:
        now, off, ways = begun
        for _ in range(1, ROUNDS):
            if not len(off):
                break
            now, off, ways = onto_sheets(contracted(now, off, ways, ahead), split.sheets, options)
        farthest = _farthest_inside(now.points[off], ways, split) if len(off) else 0.0
        if farthest < least:
            best, least = now, farthest
        if farthest == 0:
            break
    return best


def _farthest_inside(points: np.ndarray, ways: np.ndarray, split: SplitVoxels) -> float:
    """Return the length of the longest of the ways (k, 3) of points (k, 3) inside a sheet's fronts."""
    inside = np.any([look.look(points).phi > 0 for look in split.sheets], axis=0)
    return float(np.linalg.norm(ways[inside], axis=1).max(initial=0.0))


def _with_bits(surface: Surface, bits: np.ndarray) -> CutSurface:
    """Return the surface with kinds CRACK - 1 + bits for the crack's facets, psi 0 at their points."""
    kind = np.where(bits > 0, CRACK - 1 + bits, surface.kind).astype(np.uint8)
    psi = np.full(len(surface.points), np.nan)
    psi[surface.facets[bits > 0]] = 0.0
    return replace(uncut(surface), kind=kind, psi=psi, size=local_sizes(surface)[0])


def _off_most(surface: Surface, split: SplitVoxels, least: float) -> dict[str, float]:
    """Return how far off the given ones crack nodes, facets and front nodes are; refuse the farthest.

    Raises CraftmeshError where crack nodes, or nodes and middles of front edges, are farther than OFF.
    """
    ends = surface.points[front_edges(surface)]
    places = np.concatenate([ends, ends.mean(axis=1, keepdims=True)], axis=1)
    away = np.zeros(places.shape[:2])
    if len(ends):
        feet = [look.nearest_on_front(places.reshape(-1, 3)).reshape(places.shape) for look in split.sheets]
        away = np.min([np.linalg.norm(foot - places, axis=2) for foot in feet], axis=0)
        _refuse_farthest(places.reshape(-1, 3), away.ravel(), least, "ends near {} off its given front")
    facets = surface.facets[surface.kind == CRACK]
    edges, _, _ = unique_edges(facets)
    points = surface.points[np.unique(facets)]
    off = _off(points, split)
    _refuse_farthest(points, off, least, "lies near {} off the given one")
    between = np.concatenate([surface.points[edges].mean(axis=1), surface.points[facets].mean(axis=1)])
    return {
        "crack_moved_most": float(off.max()),
        "crack_off_most": float(max(off.max(), _off(between, split).max())),
        "front_off_most": float(away[:, :2].max(initial=0.0)),
    }


def _refuse_farthest(places: np.ndarray, off: np.ndarray, least: float, what: str) -> None:
    worst = int(off.argmax())
    if off[worst] > OFF * least:
        raise CraftmeshError(
            f"the crack {what.format(told(places[worst]))}: voxels are too coarse for it there; move it a "
            "little, give finer voxels or insertion cut"
        )


def _off(points: np.ndarray, split: SplitVoxels) -> np.ndarray:
    """Return how far (n,) points are off the nearest sheet, or off its continuation past its fronts."""
    found = [look.look(points) for look in split.sheets]
    away = [np.where(n.phi < 0, np.abs(n.psi), np.linalg.norm(points - n.foot, axis=1)) for n in found]
    off: np.ndarray = np.min(away, axis=0)
    return off

"""J, K_I, K_II, K_III and T at every node of a crack's front, from displacements only."""

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import fields

import numpy as np

from craftmesh.arguments import typed
from craftmesh.errors import CraftmeshError
from craftmesh.fracture.error import errors, flags_of
from craftmesh.fracture.fit import (
    Fitted,
    FrontLine,
    displacements_along_front,
    falloff,
    fit_segment,
    stress_along_binormal,
)
from craftmesh.fracture.interaction import interaction_weights
from craftmesh.fracture.lip_pressure import lip_tractions, lips_touch
from craftmesh.fracture.options import LEAST_PIECES, LEAST_RADIUS, FractureOptions
from craftmesh.fracture.segments import Segments, Stations, material_numbers, segments_of, stations_of
from craftmesh.fracture.stress_probe import probed
from craftmesh.fracture.tube import SolvedMesh, Tube, radii, tube_of
from craftmesh.mechanics.front_parameters import FrontParameters
from craftmesh.mechanics.lips import on_lips
from craftmesh.mechanics.load import Load, Traction
from craftmesh.mechanics.model import ElasticModel
from craftmesh.mesh.front_curve import FrontCurve, arc_lengths, local_sizes
from craftmesh.mesh.front_frames import Front, fronts_of, grain_of_edges
from craftmesh.types import Solution, TetMesh

# Radius of a second, smaller tube over that of the first. The difference of their K is an indicator of
# error.
SMALLER = 0.75
# Columns of K_I, K_II, K_III among the local axes binormal, normal, tangent.
_IN_ORDER = [1, 0, 2]


@typed
def stress_intensities(
    model: ElasticModel,
    solutions: Mapping[str, Solution],
    options: FractureOptions = FractureOptions(),  # noqa: B008 (frozen)
) -> tuple[dict[str, FrontParameters], dict]:
    """Return J, K and T along all fronts by load of `solutions`, and a report on the fronts.

    solutions: by name of the load, as `solve_model` returns them for the model. The report has a dict per
    load and front under "fronts". Faces of the box that the load holds, moves or pulls count as faces with
    unknown tractions. Raises CraftmeshError for 4-node meshes, displacements that do not fit, and meshes
    without a front.
    """
    models, found, fronts = model.by_load(), {}, []
    for name, solution in solutions.items():
        load = models[name].load
        found[name], report = fracture_parameters(
            model.mesh,
            solution.displacement,
            model.grains,
            model.stiffness(),
            options,
            _loaded_planes(load),
            solution.contact,
            on_lips(load),
            models[name].eigenstrain(),
            model.temperature,
        )
        fronts += [({"load_case": name} if name else {}) | front for front in report["fronts"]]
    return found, {"fronts": fronts}


def _loaded_planes(load: Load | None) -> set[str]:
    """Return the names of the box's planes that a load holds, moves or pulls; none if it is None."""
    if load is None:
        return set()
    names = {part.name for part in (*load.held, *load.moved)} | {part.name for part in load.pulled}
    return names - {part.name for part in on_lips(load)} - {""}


def fracture_parameters(
    mesh: TetMesh,
    displacement: np.ndarray,
    grains: np.ndarray,
    stiffness: np.ndarray,
    options: FractureOptions = FractureOptions(),  # noqa: B008 (frozen)
    loaded: Collection[str] = (),
    contact: np.ndarray | None = None,
    lips: Sequence[Traction] = (),
    eigenstrain: np.ndarray | None = None,
    temperature: np.ndarray | None = None,
) -> tuple[FrontParameters, dict]:
    """Return the parameters along all fronts of a solved 10-node mesh, and a report on each front.

    displacement (n, 3): of all nodes; stiffness (g, 6, 6): of grains (g,), ascending ids, in the order 11,
    22, 33, 12, 13, 23 of sample axes. Units follow from stiffness and mesh: K in stress times root of
    length. loaded: face sets (XMIN, ...) with unknown tractions, where a front may end. contact (n, 3):
    forces of touching lips on each other, None if no lips touch. lips: other tractions on the lips;
    eigenstrain (g, 3, 3): of the grains in sample axes, None for 0; temperature (n,): its factor at the
    nodes, None for 1. Raises CraftmeshError for 4-node
    meshes, displacements that do not fit, and meshes without a front.
    """
    if mesh.tets.shape[1] != 10:
        raise CraftmeshError(
            "fracture: the mesh has 4-node elements; K needs C3D10, solve with element C3D10"
        )
    if displacement.shape != mesh.points.shape or not np.isfinite(displacement).all():
        raise CraftmeshError(
            f"fracture: displacements have shape {displacement.shape} or are not finite; expected 3 finite "
            f"numbers for each of {len(mesh.points)} nodes: use the solution's element and quarter_points"
        )
    fronts = fronts_of(mesh)
    if not fronts:
        raise CraftmeshError("fracture: the mesh has no crack front; give a mesh with an opened crack")
    touch = lips_touch(mesh, contact)
    tractions = lip_tractions(mesh, lips, contact)
    strain = np.zeros((len(grains), 3, 3)) if eigenstrain is None else eigenstrain
    heat = np.ones(len(displacement)) if temperature is None else temperature
    solved = SolvedMesh(mesh, displacement, grains, stiffness, strain, loaded, tractions, touch, heat)
    corner_points = [mesh.points[front.corners] for front in fronts]
    parts, reports = [], []
    for number, front in enumerate(fronts):
        sizes = local_sizes(corner_points[number], front.closed)
        wide = radii(corner_points, number, front.closed, front.curve, sizes, options.radius)
        parameters, report = _of_front(solved, front, number + 1, wide, options)
        parts.append(parameters)
        reports.append(report)
    names = [field.name for field in fields(FrontParameters)]
    joined = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    return FrontParameters(**joined), {"fronts": reports}


def _of_front(
    solved: SolvedMesh, front: Front, number: int, wide: np.ndarray, options: FractureOptions
) -> tuple[FrontParameters, dict]:
    mesh, stiffness = solved.mesh, solved.stiffness
    line, segments = _line_and_segments(solved, front)
    stations = stations_of(segments, front.curve)
    reach = max(wide.max(), ((options.probe or 0) + 1) * line.sizes.max())
    tube = tube_of(solved, front, segments, reach)
    weights = interaction_weights(tube, front.curve, stations)
    narrow, pieces = np.maximum(SMALLER * wide, LEAST_RADIUS * line.sizes), options.knots
    tries = (wide, pieces), (narrow, pieces), (wide, max(pieces / 2, LEAST_PIECES))
    mixed = line.near(tube.others(segments, line.along(wide, tube.s)), wide)
    found = [_along(line, segments, tube, weights, radius, knots, ~mixed) for radius, knots in tries]
    moved = displacements_along_front(tube, front, line, segments)
    values = [_at_nodes(line, segments, stations, front.curve, fitted, moved) for fitted in found]
    k, t, j, g, one_sided = values[0]
    spread, by_pieces = (np.abs(k - other).max(axis=1) for other, *_ in values[1:])
    material = material_numbers(stiffness)[np.searchsorted(solved.grains, mesh.grain)]
    touch = solved.touch[front.corners]
    error = errors(k, j, g, spread, by_pieces, line, segments, one_sided, mixed)
    flags = flags_of(mesh, front, line, segments, wide, k, error, material, touch, mixed)
    count = len(front.corners)
    angle = stress = np.full(count, np.nan)
    if options.probe:
        angle, stress = probed(tube, front, line.s, options.probe * line.sizes)
    parameters = FrontParameters(
        front=np.full(count, number),
        node=front.corners,
        s=line.s,
        points=mesh.points[front.corners],
        J=j,
        G=g,
        **{name: k[:, column] for column, name in enumerate(("K_I", "K_II", "K_III"))},
        T=np.where(touch | solved.tractions.at(mesh, front.corners), np.nan, t),
        radius=wide,
        spread=spread,
        error=error,
        flags=flags,
        probe_angle=angle,
        probe_stress=stress,
    )
    return parameters, _report(parameters, segments, tube, one_sided, mixed)


def _line_and_segments(solved: SolvedMesh, front: Front) -> tuple[FrontLine, Segments]:
    mesh = solved.mesh
    points = mesh.points[front.corners]
    s, total = arc_lengths(points, front.closed)
    edges = len(s) if front.closed else len(s) - 1
    grain = grain_of_edges(mesh, front.corners[:edges], np.roll(front.corners, -1)[:edges])
    sizes = local_sizes(points, front.closed)
    line = FrontLine(s, sizes, front.curve.bend_radius(s), total, front.closed)
    own = np.searchsorted(solved.grains, grain)
    return line, segments_of(s, total, front.closed, solved.stiffness[own], solved.eigenstrain[own])


def _along(
    line: FrontLine,
    segments: Segments,
    tube: Tube,
    weights: np.ndarray,
    radius: np.ndarray,
    knots: float,
    has_j: np.ndarray,
) -> list[Fitted]:
    """Return the integrals of each segment, fitted along it, in a tube of radius (k,) at the front's nodes.

    weights (n, c): the tube nodes' contributions to the c integrals; knots: length of the spline pieces in
    local sizes; has_j (k,): mask of the front's nodes to which J is fitted.
    """
    weights = weights * falloff(tube.distance, line.along(radius, tube.s))[:, None]
    found = []
    for segment in range(len(segments.start)):
        own = (tube.segment == segment) & (weights != 0).any(axis=1)
        found.append(fit_segment(line, segments, segment, tube.s[own], weights[own], knots, has_j))
    return found


def _at_nodes(
    line: FrontLine,
    segments: Segments,
    stations: Stations,
    curve: FrontCurve,
    fitted: list[Fitted],
    moved: list[Fitted],
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, list]:
    """Return K (k, 3), T, J and G, each (k,), at the front's nodes, and a list with values at segment ends.

    The list has for each segment K and the lips' opening at its start and end, (2, 6). G is the energy
    release rate that follows from K. At a node between two segments, values are the mean of both.
    """
    count = len(line.s)
    total, times, one_sided = np.zeros((count, 6)), np.zeros(count), []
    for segment, (fit, own) in enumerate(zip(fitted, moved)):
        rows, offset = segments.within(segment, line.s)
        places = np.append(offset, [0.0, segments.length[segment]])
        values = _values(stations, segment, curve, fit, own, places, segments.eigenstrain[segment])
        total[rows] += values[:-2, :6]
        times[rows] += 1
        one_sided.append(values[-2:, [0, 1, 2, 6, 7, 8]])
    mean = total / times[:, None]
    return mean[:, :3], mean[:, 3], mean[:, 4], mean[:, 5], one_sided


def _values(
    stations: Stations,
    segment: int,
    curve: FrontCurve,
    fit: Fitted,
    moved: Fitted,
    offset: np.ndarray,
    strain: np.ndarray,
) -> np.ndarray:
    """Return columns (k, 9) of K_I, K_II, K_III, T, J, G and the opening at offsets (k,) in a segment.

    fit: fitted integrals; moved: fitted displacements and temperature; strain (3, 3): the segment's
    eigenstrain. The opening, three columns, is L^-1 K, the factor of the root of r in the crack opening
    displacement up to a constant, along binormal, normal and tangent.
    """
    s = stations.start[segment] + offset
    opening, stiffness = stations.at(segment, s)
    found = fit.at(offset)
    k = np.linalg.solve(opening, found[:, :3, None])[:, :, 0]
    _, tangent, _, binormal = curve.frames(s)
    slope = moved.slopes(offset)[:, :3] - moved.at(offset)[:, 3:] * (tangent @ strain)
    along = np.column_stack([(slope * axis).sum(axis=1) for axis in (tangent, binormal)])
    t = stress_along_binormal(stiffness, found[:, 3:5], along)
    g = 0.5 * (k * found[:, :3]).sum(axis=1)
    return np.column_stack([k[:, _IN_ORDER], t, found[:, 5], g, found[:, :3]])


def _report(
    parameters: FrontParameters, segments: Segments, tube: Tube, one_sided: list, mixed: np.ndarray
) -> dict:
    """Return the report of a front: size, its tube, flags, K at the ends of segments, and errors.

    The errors of K (least, median, most) are relative to the front's largest K. one_sided: for each segment
    K and the lips' opening (2, 6) at its ends, from the segment's own side. mixed (n,): mask
    of nodes with other materials nearby, which are left out of the ratio of J to G.
    """
    largest = np.abs([parameters.K_I, parameters.K_II, parameters.K_III]).max()
    words = Counter(word for flags in parameters.flags.tolist() for word in flags.split("+") if word)
    j, g = parameters.J[~mixed], parameters.G[~mixed]
    ratio = np.sqrt(np.maximum(j, 0) / np.maximum(g, np.finfo(float).tiny))
    return {
        "front": int(parameters.front[0]),
        "nodes": len(parameters.node),
        "closed": segments.closed,
        "length": segments.total,
        "elements": len(tube.tets),
        "free_faces": len(tube.faces),
        "radius": [float(parameters.radius.min()), float(parameters.radius.max())],
        "largest_K": float(largest),
        "error": _least_middle_most(parameters.error / (largest or 1.0)),
        "root_of_J_over_G": _least_middle_most(ratio) if len(ratio) else None,
        "flagged": dict(words),
        "segments": [
            {"start": float(start), "length": float(length), "K_at_ends": ends[:, :3].tolist()}
            for start, length, ends in zip(segments.start, segments.length, one_sided)
        ],
    }


def _least_middle_most(values: np.ndarray) -> list[float]:
    """Return the smallest, the median and the largest of values (k,)."""
    return [float(values.min()), float(np.median(values)), float(values.max())]

"""Interaction integrals: contributions of the nodes of a front's tube to the integrals of K, T and J.

A contribution is the integral for a virtual extension q that is 1 at one node and 0 at all others.
"""

from typing import NamedTuple

import numpy as np

from craftmesh.fracture.fields import fields_at, stresses
from craftmesh.fracture.segments import Stations
from craftmesh.fracture.tube import Tube
from craftmesh.mechanics.near_field import MODES, as_tensor
from craftmesh.mesh.front_curve import FrontCurve
from craftmesh.mesh.integration import (
    FULL_RULE,
    corner_shares,
    face_rules,
    jacobians,
    parts_of,
    shape_slopes,
    shape_values,
    tet_rule,
)
from craftmesh.mesh.tet_connectivity import face_nodes

# Number of integrals; the last one is J's.
ROWS = MODES + 1
# Number of elements that are processed at once, with arrays of 4 MB.
AT_ONCE = 200


class Points(NamedTuple):
    """Integration points (p,), each in an element.

    value (p, 10), slope (p, 10, 3): shape functions and their derivatives in space; place (p, 3); cofactors
    (p, 3, 3) and determinant (p,): of the Jacobian; guess (p,): estimated s of the nearest point on the
    front.
    """

    element: np.ndarray
    value: np.ndarray
    slope: np.ndarray
    place: np.ndarray
    cofactors: np.ndarray
    determinant: np.ndarray
    guess: np.ndarray


class Local(NamedTuple):
    """Quantities at points (p,), in the local axes (p, 3, 3) of each point.

    across (p, 10, 3): binormals at the element's nodes; gradient (p, 3, 3): the element's displacement
    gradient less `free` times the temperature; own (p, 3, 3): the element's stress; free, own_free (p, 3,
    3): eigenstrains at temperature 1 of the grain at the front and of the element's; warming (p, 3): slope
    of the temperature; energy (p,): the element's elastic energy density; h, dh, stress, dstress: gradients
    and stresses of the crystal's fields, with derivatives, as in `PointFields`.
    """

    axes: np.ndarray
    across: np.ndarray
    gradient: np.ndarray
    own: np.ndarray
    free: np.ndarray
    own_free: np.ndarray
    warming: np.ndarray
    energy: np.ndarray
    h: np.ndarray
    dh: np.ndarray
    stress: np.ndarray
    dstress: np.ndarray


def interaction_weights(tube: Tube, curve: FrontCurve, stations: Stations) -> np.ndarray:
    """Return each tube node's contributions (n, ROWS) to the integrals of K, T and J.

    q, the virtual extension, is along the binormal at the node's nearest point on the front.
    """
    weights = np.zeros((len(tube.nodes), ROWS))
    for segment in range(len(stations.start)):
        own = tube.segment[tube.tets] == segment
        for elements in parts_of(np.flatnonzero(own.any(axis=1)), AT_ONCE):
            found = _of_elements(tube, curve, stations, segment, elements)
            np.add.at(weights, tube.tets[elements], np.where(own[elements][:, :, None], found, 0.0))
        for faces in parts_of(np.flatnonzero(own[tube.faces[:, 0]].any(axis=1)), AT_ONCE):
            elements = tube.faces[faces, 0]
            found = _outer_face_terms(tube, curve, stations, segment, faces)
            np.add.at(weights, tube.tets[elements], np.where(own[elements][:, :, None], found, 0.0))
    return weights


def _points(
    tube: Tube, curve: FrontCurve, element: np.ndarray, value: np.ndarray, slope: np.ndarray
) -> Points:
    """Return integration points in elements (p,), rows of the tube.

    value (p, 10), slope (p, 10, 3): shape functions and their derivatives by the element's coordinates.
    """
    nodes = tube.tets[element]
    jacobian = jacobians(tube.points, nodes, slope[:, None])[:, 0]
    cofactors = np.stack([np.cross(jacobian[:, i - 2], jacobian[:, i - 1]) for i in range(3)], axis=1)
    determinant = (jacobian[:, 0] * cofactors[:, 0]).sum(axis=1)
    in_space = slope @ cofactors.swapaxes(1, 2) / determinant[:, None, None]
    s = tube.s[nodes]
    if curve.closed:
        s = s[:, :1] + np.mod(s - s[:, :1] + curve.length / 2, curve.length) - curve.length / 2
    place = (value[:, None] @ tube.points[nodes])[:, 0]
    return Points(element, value, in_space, place, cofactors, determinant, (value * s).sum(axis=1))


def _local(
    tube: Tube, curve: FrontCurve, stations: Stations, segment: int, points: Points, side: np.ndarray
) -> Local:
    """Return the quantities of the integrands at integration points, in their local axes.

    side (p,): 1 on the side of lip A, -1 on the side of lip B.
    """
    s = curve.nearest(points.place, points.guess)
    frames = curve.moving_frames(s)
    fields = fields_at(stations, segment, s, frames, points.place, side)
    nodes, grain = tube.tets[points.element], tube.grain[points.element]
    heat, warming = tube.temperature[nodes], (tube.temperature[nodes][:, None] @ points.slope)[:, 0]
    heat = (heat * points.value).sum(axis=1)[:, None, None]
    strain, front = tube.eigenstrain[grain], tube.shift[segment]
    raw = tube.displacement[nodes].swapaxes(1, 2) @ points.slope - heat * strain
    stress = stresses(as_tensor(tube.stiffness).reshape(-1, 9, 9)[grain], raw)
    energy = 0.5 * (stress * raw).sum(axis=(1, 2))
    axes, turned = frames.axes, frames.axes.swapaxes(1, 2)
    gradient, own, free, own_free = (
        axes @ part @ turned for part in (raw + heat * (strain - front), stress, front, strain)
    )
    across = tube.binormal[nodes] @ turned
    return Local(axes, across, gradient, own, free, own_free, _times(axes, warming), energy, *fields)


def _of_elements(
    tube: Tube, curve: FrontCurve, stations: Stations, segment: int, elements: np.ndarray
) -> np.ndarray:
    """Return the contributions (e, 10, ROWS) of the elements' nodes: the integral of P grad N + B N.

    N are the shape functions, P = s h + s' grad u - (s' : e) 1 and B = div s' . grad u + s : grad h - grad
    s' : e, where h, s' are the gradient and stress of a crystal's field and s, e the stress and strain of
    the element. No derivative of the material is needed. From grad u the eigenstrain of the grain at the
    front is subtracted, so that s is C e there. Where the temperature varies, B also has `_of_warming`. For
    J, P is the energy-momentum tensor and B has only these terms.
    """
    (share, weights), count = tet_rule(FULL_RULE), len(elements)
    element = np.repeat(elements, len(weights))
    value, slope = np.tile(shape_values(share), (count, 1)), np.tile(shape_slopes(share, 10), (count, 1, 1))
    points = _points(tube, curve, element, value, slope)
    at = _local(tube, curve, stations, segment, points, tube.side[element])
    own, u = at.own, at.gradient
    flow = np.empty((len(u), 3, ROWS, 3))  # components i, field, k
    flow[:, :, :MODES] = (own @ at.h.reshape(-1, 3, 3 * MODES)).reshape(at.h.shape)
    flow[:, :, :MODES] += (at.stress.reshape(-1, 3 * MODES, 3) @ u).reshape(at.stress.shape).swapaxes(1, 2)
    flow[:, :, MODES] = own @ u
    energy = _energies(at)
    for k in range(3):
        flow[:, k, :, k] -= energy
    pieces = at.dstress.reshape(-1, 3 * MODES, 9) @ u.reshape(-1, 9, 1)
    body = sum(at.dstress[:, k, :, k] for k in range(3)) @ u
    body += (own.reshape(-1, 1, 9) @ at.dh.reshape(-1, 9, 3 * MODES)).reshape(body.shape)
    body -= pieces.reshape(-1, 3, MODES).swapaxes(1, 2)
    local_slope = points.slope @ at.axes.swapaxes(1, 2)
    force = (local_slope @ flow.reshape(-1, 3, 3 * ROWS)).reshape(-1, 10, ROWS, 3)
    warming = _of_warming(at)
    warming[:, :MODES] += body
    force += value[:, :, None, None] * warming[:, None]
    weight = np.tile(weights, count) * points.determinant
    return np.einsum("pamk,pak,p->pam", force, at.across, weight).reshape(count, -1, 10, ROWS).sum(axis=1)


def _of_warming(at: Local) -> np.ndarray:
    """Return the terms (p, ROWS, 3) of B by the slope of the temperature g: (s' : a) g - a_0 s' g.

    a_0 is the eigenstrain of the grain at the front at temperature 1. For K and T s' is the stress of a
    crystal's field and a is a_0; for J they are the stress and the eigenstrain of the element.
    """
    stress = np.concatenate([at.stress, at.own[:, None]], axis=1)
    work = np.column_stack(
        [
            (at.stress.reshape(-1, MODES, 9) @ at.free.reshape(-1, 9, 1))[:, :, 0],
            (at.own * at.own_free).sum(axis=(1, 2)),
        ]
    )
    pull = (stress @ at.warming[:, None, :, None])[..., 0]
    return work[:, :, None] * at.warming[:, None] - pull @ at.free


def _energies(at: Local) -> np.ndarray:
    """Return energy densities (p, ROWS): s' : e, the interaction with each field, and the elastic one."""
    shared = at.stress.reshape(-1, MODES, 9) @ at.gradient.reshape(-1, 9, 1)
    return np.column_stack([shared[:, :, 0], at.energy])


def _outer_face_terms(
    tube: Tube, curve: FrontCurve, stations: Stations, segment: int, faces: np.ndarray
) -> np.ndarray:
    """Return the contributions (f, 10, ROWS) of the nodes of elements at outer faces that q may move.

    They are the integral of N ((s' : e) m - (s' m) . grad u - t . h), with the face's normal m and the
    traction t: the given one, or on loaded faces the element's own, s m. For J they are the elastic energy
    times m, less t . grad u. Terms with m count where lips are curved or q has a part along m; they are
    left out on lip faces that touch the front.
    """
    rules, count = face_rules(), len(faces)
    row, share = np.repeat(faces, len(rules.weight)), np.tile(rules.share, (count, 1))
    element, face = tube.faces[row].T
    own_faces = tube.faces[faces, 1]
    value, slope = rules.value[own_faces].reshape(-1, 10), rules.slope[own_faces].reshape(-1, 10, 3)
    points = _points(tube, curve, element, value, slope)
    normal = np.tile(rules.weight, count)[:, None] * _times(points.cofactors, rules.outward[face])
    area, touches = np.linalg.norm(normal, axis=1), tube.at_front[row].any(axis=1)
    traction = tube.traction[faces].reshape(-1, 3)
    if touches.any():
        own = Points(*(part[touches] for part in points))
        place, stretch = _begun_at_curve(tube, curve, own, share[touches], row[touches])
        traction[touches] += _changes(tube, row[touches], own.place, place, traction[touches])
        points.place[touches] = place
        area[touches] *= stretch
    at = _local(tube, curve, stations, segment, points, tube.face_side[row])
    m, u = _times(at.axes, normal), at.gradient
    pull = area[:, None] * _times(at.axes, traction)
    pull = np.where(tube.loaded[row, None], _times(at.own, m), pull)
    fields = np.concatenate([at.h, u[:, :, None]], axis=2).reshape(-1, 3, 3 * ROWS)
    force = -(pull[:, None] @ fields).reshape(-1, ROWS, 3)
    bent = _energies(at)[:, :, None] * m[:, None]
    bent[:, :MODES] -= (m[:, None, None] @ at.stress)[:, :, 0] @ u
    force[~touches] += bent[~touches]
    found = value[:, :, None] * (at.across @ force.swapaxes(1, 2))
    return found.reshape(count, -1, 10, ROWS).sum(axis=1)


def _times(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Return the products (p, 3) of matrices (p, 3, 3) and vectors (p, 3)."""
    return (matrices @ vectors[:, :, None])[:, :, 0]


def _changes(
    tube: Tube, row: np.ndarray, start: np.ndarray, end: np.ndarray, traction: np.ndarray
) -> np.ndarray:
    """Return changes (p, 3) of tractions (p, 3) at points that move from start to end (p, 3).

    row (p,): face of each point. A linear function is fitted to each face's tractions. Without these
    changes, K of a crack with five edges to its radius, under a traction that grows with r to the fourth,
    was 0.6 % less, because the front's edges are chords.
    """
    count = (len(row) // tube.traction.shape[1], tube.traction.shape[1])
    corners = tube.points[face_nodes(tube.tets[:, :4], tube.faces[row[:: count[1]]])]
    first, last = (corner_shares(corners, places.reshape(*count, 3)) for places in (start, end))
    return ((last - first) @ (np.linalg.pinv(first) @ traction.reshape(*count, 3))).reshape(-1, 3)


def _begun_at_curve(
    tube: Tube, curve: FrontCurve, points: Points, share: np.ndarray, row: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return new positions (p, 3) of points on lip facets at the front, and the ratio (p,) of their areas.

    The facets end at chords of the front's curve. Points are moved as if the facets ended at the curve:
    points on the chord onto the curve, others by less, to 0 at the opposite side or corner of the facet.
    Near the front the fields grow with 1 / root(r), so that without this 6 % of the K of a pressure were
    missing with ten edges to the crack's radius. row (p,): the facet in the tube's faces; share (p, 3):
    barycentric coordinates in it.
    """
    corners = tube.points[face_nodes(tube.tets[:, :4], tube.faces[row])].swapaxes(1, 2)
    at_front = tube.at_front[row]
    base = (share * at_front).sum(axis=1)
    foot = _times(corners, share * at_front) / base[:, None]
    inner = _times(corners, share * ~at_front) / np.maximum(1 - base, 1e-9)[:, None]
    off = curve.frames(curve.nearest(foot, points.guess))[0] - foot
    way = inner - foot
    width = (way * way).sum(axis=1)
    fade = 1 - np.linalg.norm(points.place - foot, axis=1) / np.sqrt(width)
    on_chord = base > 1 - 1e-9
    fade, along = (np.where(on_chord, 0.0, part) for part in (fade, (way * off).sum(axis=1)))
    return points.place + fade[:, None] * off, (1 - along / width) ** 2

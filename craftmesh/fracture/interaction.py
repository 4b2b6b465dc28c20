"""Interaction integrals: what each node of the tube round a front adds to those of the K, of T and of J."""

from typing import NamedTuple

import numpy as np

from craftmesh.fracture.fields import fields_at, stresses
from craftmesh.fracture.quadrature import element_rule, face_rules
from craftmesh.fracture.segments import Stations
from craftmesh.fracture.tube import Tube
from craftmesh.mechanics.near_field import MODES, as_tensor
from craftmesh.mesh.front_curve import FrontCurve
from craftmesh.mesh.integration import jacobians, parts_of
from craftmesh.mesh.tet_connectivity import FACE_CORNERS

# The last row is that of J.
ROWS = MODES + 1
# Elements whose points are worked on at once: arrays of 4 MB.
AT_ONCE = 200


class Points(NamedTuple):
    """Points of integration in elements (e,), q in each.

    value (e, q, 10), slope (e, q, 10, 3): shape functions and their derivatives in space; place (e, q, 3);
    cofactors (e, q, 3, 3): of the Jacobian, whose determinants (e, q) are; guess (e, q): of the s of the
    nearest point on the front.
    """

    element: np.ndarray
    value: np.ndarray
    slope: np.ndarray
    place: np.ndarray
    cofactors: np.ndarray
    determinant: np.ndarray
    guess: np.ndarray


def interaction_weights(tube: Tube, curve: FrontCurve, stations: Stations) -> np.ndarray:
    """Return the nodes' parts (n, ROWS) of the integrals, for a q of 1 at the node along its binormal."""
    weights = np.zeros((len(tube.nodes), ROWS))
    for segment in range(len(stations.start)):
        own = tube.segment[tube.tets] == segment
        for elements in parts_of(np.flatnonzero(own.any(axis=1)), AT_ONCE):
            found = _of_elements(tube, curve, stations, segment, elements)
            np.add.at(weights, tube.tets[elements], np.where(own[elements][:, :, None], found, 0.0))
        for faces in parts_of(np.flatnonzero(own[tube.faces[:, 0]].any(axis=1)), AT_ONCE):
            elements = tube.faces[faces, 0]
            found = _of_faces(tube, curve, stations, segment, faces)
            np.add.at(weights, tube.tets[elements], np.where(own[elements][:, :, None], found, 0.0))
    return weights


def _points(
    tube: Tube, curve: FrontCurve, element: np.ndarray, value: np.ndarray, slope: np.ndarray
) -> Points:
    """Return points of elements (e,); value (e or 1, q, 10), slope (e or 1, q, 10, 3): of their rule."""
    nodes = tube.tets[element]
    jacobian = jacobians(tube.points, nodes, slope)
    rows = [np.cross(jacobian[..., (i + 1) % 3, :], jacobian[..., (i + 2) % 3, :]) for i in range(3)]
    cofactors = np.stack(rows, axis=2)
    determinant = (jacobian[..., 0, :] * cofactors[..., 0, :]).sum(axis=2)
    in_space = slope @ cofactors.swapaxes(2, 3) / determinant[..., None, None]
    place = (value[:, :, None, :] @ tube.points[nodes][:, None])[:, :, 0]
    s = tube.s[nodes]
    if curve.closed:
        s = s[:, :1] + np.mod(s - s[:, :1] + curve.length / 2, curve.length) - curve.length / 2
    guess = (value @ s[:, :, None])[..., 0]
    value = np.broadcast_to(value, (*guess.shape, 10))
    return Points(element, value, in_space, place, cofactors, determinant, guess)


def _flat(values: np.ndarray) -> np.ndarray:
    """Return values (e, q, ...) of points one after the other."""
    return values.reshape(-1, *values.shape[2:])


class Local(NamedTuple):
    """What the points (p,) have in their local axes (p, 3, 3).

    across (p, 10, 3): the nodes' binormals; gradient (p, 3, 3): the element's displacement gradient less
    the eigenstrain of the grain at the front; own (p, 3, 3): its stress; energy (p,): its elastic energy; h
    and others: see `PointFields`.
    """

    axes: np.ndarray
    across: np.ndarray
    gradient: np.ndarray
    own: np.ndarray
    energy: np.ndarray
    h: np.ndarray
    dh: np.ndarray
    stress: np.ndarray
    dstress: np.ndarray


def _local(
    tube: Tube, curve: FrontCurve, stations: Stations, segment: int, points: Points, side: np.ndarray
) -> Local:
    """Return what is integrated; side (e,): see `fields_at`."""
    per = points.guess.shape[1]
    s = curve.nearest(_flat(points.place), points.guess.ravel())
    frames = curve.moving_frames(s)
    fields = fields_at(stations, segment, s, frames, _flat(points.place), np.repeat(side, per))
    nodes, grain = tube.tets[points.element], np.repeat(tube.grain[points.element], per)
    strain = tube.eigenstrain[grain]
    raw = _flat(tube.displacement[nodes][:, None].swapaxes(2, 3) @ points.slope) - strain
    stress = stresses(as_tensor(tube.stiffness).reshape(-1, 9, 9)[grain], raw)
    energy = 0.5 * (stress * raw).sum(axis=(1, 2))
    axes, turned = frames.axes, frames.axes.swapaxes(1, 2)
    gradient = axes @ (raw + strain - tube.shift[segment]) @ turned
    across = np.repeat(tube.binormal[nodes], per, axis=0) @ turned
    return Local(axes, across, gradient, axes @ stress @ turned, energy, *fields)


def _of_elements(
    tube: Tube, curve: FrontCurve, stations: Stations, segment: int, elements: np.ndarray
) -> np.ndarray:
    """Return the parts (e, 10, ROWS) of the elements' nodes: the integral of P grad N + B N for each.

    P = s h + s' grad u - (s' : e) 1 and B = div s' . grad u + s : grad h - grad s' : e, with h, s' the
    fields of a crystal and s, e those of the element, so that no derivative of the material is asked for.
    u is less the uniform eigenstrain of the grain at the front, so that s is C e there as without one. Of
    J, P is the tensor of energy and momentum.
    """
    rule = element_rule()
    points = _points(tube, curve, elements, rule.value[None], rule.slope[None])
    at = _local(tube, curve, stations, segment, points, tube.side[elements])
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
    slope = _flat(points.slope) @ at.axes.swapaxes(1, 2)
    force = (slope @ flow.reshape(-1, 3, 3 * ROWS)).reshape(-1, 10, ROWS, 3)
    force[:, :, :MODES] += _flat(points.value)[:, :, None, None] * body[:, None]
    weight = (rule.weight * points.determinant).ravel()
    found = np.einsum("pamk,pak,p->pam", force, at.across, weight)
    return found.reshape(len(elements), -1, 10, ROWS).sum(axis=1)


def _energies(at: Local) -> np.ndarray:
    """Return s' : e of each field, and the elastic energy (p, ROWS)."""
    shared = at.stress.reshape(-1, MODES, 9) @ at.gradient.reshape(-1, 9, 1)
    return np.column_stack([shared[:, :, 0], at.energy])


def _of_faces(
    tube: Tube, curve: FrontCurve, stations: Stations, segment: int, faces: np.ndarray
) -> np.ndarray:
    """Return the parts (f, 10, ROWS) of the nodes of elements at outer faces that q may move.

    They are the integral of N ((s' : e) m - (s' m) . grad u - t . h), m the normal and t the traction: the
    given one, or on loaded faces the element's own, s m; for J the elastic energy times m, less t . grad u.
    Lips are not straight, which is left out where corners are on the front; on others q has a part along
    their normal.
    """
    rules, (element, face) = face_rules(), tube.faces[faces].T
    points = _points(tube, curve, element, rules.value[face], rules.slope[face])
    normal = rules.weight[:, None] * (points.cofactors @ rules.outward[face][:, None, :, None])[..., 0]
    area, touches = np.linalg.norm(normal, axis=2), tube.at_front[faces].any(axis=1)
    if touches.any():
        points.place[touches], stretch = _begun_at_curve(tube, curve, points, rules.share, faces, touches)
        area[touches] *= stretch
    at = _local(tube, curve, stations, segment, points, tube.face_side[faces])
    turned, u = at.axes.swapaxes(1, 2), at.gradient
    m = _flat(normal[:, :, None, :]) @ turned
    pull = _flat((area[:, :, None] * (rules.share @ tube.traction[faces]))[:, :, None, :]) @ turned
    per = len(rules.weight)
    pull = np.where(np.repeat(tube.loaded[faces], per)[:, None, None], m @ at.own, pull)
    fields = np.concatenate([at.h, u[:, :, None]], axis=2).reshape(-1, 3, 3 * ROWS)
    force = -(pull @ fields).reshape(-1, ROWS, 3)
    bent = _energies(at)[:, :, None] * m
    bent[:, :MODES] -= (m[:, None] @ at.stress)[:, :, 0] @ u
    force += np.where(np.repeat(touches, per)[:, None, None], 0.0, bent)
    found = _flat(points.value)[:, :, None] * (at.across @ force.swapaxes(1, 2))
    return found.reshape(len(faces), per, 10, ROWS).sum(axis=1)


def _begun_at_curve(
    tube: Tube, curve: FrontCurve, points: Points, share: np.ndarray, faces: np.ndarray, chosen: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return places (f, q, 3) on chosen lips as if these began at the front's curve, and the stretches.

    Near the front the fields grow with 1 / root(r): on its chords 6 % of a pressure's K are missing with
    ten edges to the radius. A place lies between one on the chord and one on the other side of the facet,
    at shares of its corners (q, 3).
    """
    place, (element, face) = points.place[chosen], tube.faces[faces[chosen]].T
    corners = tube.points[np.take_along_axis(tube.tets[element], FACE_CORNERS[face], axis=1)]
    at_front = tube.at_front[faces[chosen]][:, None, :]
    base = (share * at_front).sum(axis=2, keepdims=True)
    rest = np.maximum(1 - base, 1e-9)
    foot, inner = (share * at_front) @ corners / base, (share * ~at_front) @ corners / rest
    s = curve.nearest(_flat(foot), points.guess[chosen].ravel())
    off = curve.frames(s)[0].reshape(foot.shape) - foot
    way = inner - foot
    width = (way * way).sum(axis=2, keepdims=True)
    fade = 1 - np.linalg.norm(place - foot, axis=2, keepdims=True) / np.sqrt(width)
    fade, along = (
        np.where(base > 1 - 1e-9, 0.0, part) for part in (fade, (way * off).sum(axis=2, keepdims=True))
    )
    return place + fade * off, (1 - along[..., 0] / width[..., 0]) ** 2

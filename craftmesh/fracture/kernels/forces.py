"""Nodal interaction forces of the elements and free faces in the tube round a crack front."""

from typing import NamedTuple

import numpy as np

from craftmesh.fracture.kernels.curve import AXES, POINT, nearest
from craftmesh.fracture.kernels.fields import MODES, contract, fill_fields
from craftmesh.jit import kernel
from craftmesh.mesh.tet_connectivity import FACE_CORNERS

# The last row of the forces is that of J.
ROWS = MODES + 1


class Tube(NamedTuple):
    """Elements round a front: tets (e, 10) ids of the nodes of the tube; stiffness (g, 6, 6) of its grains.

    eigenstrain (g, 3, 3) of its grains; shift (k, 3, 3): that of the grain at the front in each segment.
    points, displacement (n, 3) of its nodes; s (n,) their nearest points on the front; segment (n,) of the
    front; grain (e,) row of stiffness; side (e,): 1 on the side of lip A, -1 on that of lip B.
    """

    tets: np.ndarray
    points: np.ndarray
    displacement: np.ndarray
    s: np.ndarray
    segment: np.ndarray
    grain: np.ndarray
    side: np.ndarray
    stiffness: np.ndarray
    eigenstrain: np.ndarray
    shift: np.ndarray


class Rule(NamedTuple):
    """Points of integration: values (p, 10) and slopes (p, 10, 3) of the shape functions, weights (p,)."""

    value: np.ndarray
    slope: np.ndarray
    weight: np.ndarray


class Work(NamedTuple):
    """Arrays that one point after another fills."""

    frame: np.ndarray
    h: np.ndarray
    dh: np.ndarray
    stress: np.ndarray
    dstress: np.ndarray
    jacobian: np.ndarray
    slope: np.ndarray
    place: np.ndarray
    gradient: np.ndarray
    own: np.ndarray
    energy: np.ndarray
    tensor: np.ndarray


@kernel
def _work():
    return Work(
        np.zeros((8, 3)),
        np.zeros((MODES, 3, 3)),
        np.zeros((3, MODES, 3, 3)),
        np.zeros((MODES, 3, 3)),
        np.zeros((3, MODES, 3, 3)),
        np.zeros((3, 3)),
        np.zeros((10, 3)),
        np.zeros(3),
        np.zeros((3, 3)),
        np.zeros((3, 3)),
        np.zeros(1),
        np.zeros((3, 3)),
    )


@kernel
def add_element_forces(tube, curve, fields, rule, forces):
    """Add to `forces` (n, ROWS, 3) those of the elements: the integral of P grad N + B N for each node.

    P = s h + s' grad u - (s' : e) 1 and B = div s' . grad u + s : grad h - grad s' : e, with h, s' the
    fields of a crystal and s, e those of the element, so that no derivative of the material is asked for.
    An element with nodes of two segments counts for each with the fields of that segment. u is less the
    uniform eigenstrain of the grain at the front, so that s is C e there as without one.
    """
    work = _work()
    for e in range(len(tube.tets)):
        nodes = tube.tets[e]
        for k in range(10):
            segment = tube.segment[nodes[k]]
            again = False
            for other in range(k):
                again = again or tube.segment[nodes[other]] == segment
            if not again:
                _add_element(tube, curve, fields, rule, forces, work, e, segment)


@kernel
def _add_element(tube, curve, fields, rule, forces, work, e, segment):
    nodes = tube.tets[e]
    guess = tube.s[nodes[0]]
    force = np.zeros((ROWS, 3, 3))
    body = np.zeros((ROWS, 3))
    for q in range(len(rule.weight)):
        weight = rule.weight[q] * _map(tube.points, nodes, rule.value[q], rule.slope[q], work)
        guess = _fill_point(tube, curve, fields, work, e, segment, guess)
        _fill_element(tube, e, segment, work)
        for m in range(MODES):
            _mode(work, m, force[m], body[m])
        _momentum(work.gradient, work.own, work.energy[0], force[MODES])
        axes = work.frame[AXES : AXES + 3]
        for k in range(10):
            if tube.segment[nodes[k]] == segment:
                local = _to_axes(axes, work.slope[k])
                for m in range(ROWS):
                    v0 = _along(force[m, 0], local) + body[m, 0] * rule.value[q, k]
                    v1 = _along(force[m, 1], local) + body[m, 1] * rule.value[q, k]
                    v2 = _along(force[m, 2], local) + body[m, 2] * rule.value[q, k]
                    for i in range(3):
                        forces[nodes[k], m, i] += weight * (
                            v0 * axes[0, i] + v1 * axes[1, i] + v2 * axes[2, i]
                        )


@kernel
def _along(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def _to_axes(axes, v):
    return (_along(axes[0], v), _along(axes[1], v), _along(axes[2], v))


@kernel
def _map(points, nodes, value, slope, work):
    """Fill the place and the shape functions' slopes in space; return the Jacobian's determinant."""
    j = work.jacobian
    j[:] = 0.0
    work.place[:] = 0.0
    for k in range(10):
        for i in range(3):
            x = points[nodes[k], i]
            work.place[i] += value[k] * x
            for axis in range(3):
                j[i, axis] += x * slope[k, axis]
    c = work.tensor  # the cofactors, by which the inverse's transpose is c / determinant
    for i in range(3):
        a, b = (i + 1) % 3, (i + 2) % 3
        for axis in range(3):
            f, g = (axis + 1) % 3, (axis + 2) % 3
            c[i, axis] = j[a, f] * j[b, g] - j[a, g] * j[b, f]
    determinant = _along(j[0], c[0])
    for k in range(10):
        for i in range(3):
            work.slope[k, i] = _along(c[i], slope[k]) / determinant
    return determinant


@kernel
def _fill_point(tube, curve, fields, work, e, segment, guess):
    """Fill frame and fields at the place in work; return its s."""
    s = nearest(curve, work.place, guess, work.frame)
    fill_fields(
        fields, segment, s, work.frame, work.place, tube.side[e], work.h, work.dh, work.stress, work.dstress
    )
    return s


@kernel
def _fill_element(tube, e, segment, work):
    """Fill the element's displacement gradient and its stress in the local axes, and its elastic energy.

    The gradient is less the eigenstrain of the grain at the segment of the front.
    """
    nodes, own = tube.tets[e], tube.eigenstrain[tube.grain[e]]
    raw, stress, axes = -own, np.empty((3, 3)), work.frame[AXES : AXES + 3]
    for k in range(10):
        for i in range(3):
            u = tube.displacement[nodes[k], i]
            for j in range(3):
                raw[i, j] += u * work.slope[k, j]
    contract(tube.stiffness[tube.grain[e]], raw, stress)
    work.energy[0] = 0.5 * (stress * raw).sum()
    raw += own - tube.shift[segment]
    _rotate(axes, raw, work.gradient)
    _rotate(axes, stress, work.own)


@kernel
def _rotate(axes, tensor, result):
    for i in range(3):
        for j in range(3):
            total = 0.0
            for a in range(3):
                for b in range(3):
                    total += axes[i, a] * tensor[a, b] * axes[j, b]
            result[i, j] = total


@kernel
def _mode(work, m, force, body):
    """Fill P (3, 3), row k along q, and B (3,) of one field."""
    h, aux, own, u = work.h[m], work.stress[m], work.own, work.gradient
    energy = 0.0
    for i in range(3):
        for j in range(3):
            energy += aux[i, j] * u[i, j]
    for k in range(3):
        body[k] = 0.0
        for i in range(3):
            total = -energy if i == k else 0.0
            for j in range(3):
                total += own[i, j] * h[j, k] + aux[i, j] * u[j, k]
                body[k] += (
                    work.dstress[i, m, i, j] * u[j, k]
                    + own[i, j] * work.dh[i, m, j, k]
                    - work.dstress[k, m, i, j] * u[i, j]
                )
            force[k, i] = total


@kernel
def _momentum(u, own, energy, force):
    """Fill the energy-momentum tensor (3, 3), row k along q."""
    for k in range(3):
        for i in range(3):
            force[k, i] = -energy if i == k else 0.0
            for j in range(3):
                force[k, i] += own[i, j] * u[j, k]


@kernel
def add_face_forces(
    tube, curve, fields, faces, sides, at_front, loaded, traction, rules, outward, share, forces
):
    """Add to `forces` (n, ROWS, 3) those of outer faces (f, 2), rows (element, face), which q may move.

    Lips are not straight, which is left out where corners are on the front: at_front (f, 3); on others q
    has a part along their normal. traction (f, 3, 3): at the corners of faces; loaded (f,): faces with the
    element's own. sides (f,): as the element's in Tube; rules: value (4, p, 10), slope (4, p, 10, 3),
    weight (p,) of the four faces; outward (4, 3): their normals in the element's own coordinates; share (p,
    3): of the corners.
    """
    work = _work()
    normal, pull, force = np.zeros(3), np.zeros(3), np.zeros((ROWS, 3))
    for f in range(len(faces)):
        e, face = faces[f]
        nodes = tube.tets[e]
        guess = tube.s[nodes[0]]
        for q in range(len(rules.weight)):
            _map(tube.points, nodes, rules.value[face, q], rules.slope[face, q], work)
            for i in range(3):
                normal[i] = rules.weight[q] * _along(work.tensor[i], outward[face])
            area = np.sqrt(_along(normal, normal))
            touches = at_front[f].any()
            if touches:
                area *= _begin_at_curve(
                    tube, curve, nodes[FACE_CORNERS[face]], at_front[f], share[q], guess, work
                )
            for i in range(3):
                pull[i] = area * _along(traction[f, :, i], share[q])
            for k in range(10):
                segment = tube.segment[nodes[k]]
                again = rules.value[face, q, k] == 0.0
                for other in range(k):
                    again = again or (
                        tube.segment[nodes[other]] == segment and rules.value[face, q, other] != 0.0
                    )
                if not again:
                    s = nearest(curve, work.place, guess, work.frame)
                    fill_fields(
                        fields, segment, s, work.frame, work.place, sides[f],
                        work.h, work.dh, work.stress, work.dstress,
                    )  # fmt: skip
                    _fill_element(tube, e, segment, work)
                    axes = work.frame[AXES : AXES + 3]
                    _across(work, _to_axes(axes, normal), _to_axes(axes, pull), loaded[f], touches, force)
                    _add_face_point(tube, nodes, segment, rules.value[face, q], axes, force, forces)


@kernel
def _begin_at_curve(tube, curve, corners, at_front, share, guess, work):
    """Move the place on a lip as if it began at the front's curve, not at its chords; return the stretch.

    Near the front the fields grow with 1 / root(r): without, 6 % of a pressure's K are missing with ten
    edges to the radius. The place lies between one on the chord and one on the other side of the facet, at
    shares of its corners (3,).
    """
    base = 0.0
    for c in range(3):
        base += share[c] * at_front[c]
    if base > 1.0 - 1e-9:
        return 1.0
    foot, inner = np.zeros(3), np.zeros(3)
    for c in range(3):
        for i in range(3):
            if at_front[c]:
                foot[i] += share[c] / base * tube.points[corners[c], i]
            else:
                inner[i] += share[c] / (1.0 - base) * tube.points[corners[c], i]
    nearest(curve, foot, guess, work.frame)
    along, width, away = 0.0, 0.0, 0.0
    for i in range(3):
        along += (inner[i] - foot[i]) * (work.frame[POINT, i] - foot[i])
        width += (inner[i] - foot[i]) ** 2
        away += (work.place[i] - foot[i]) ** 2
    fade = 1.0 - np.sqrt(away / width)
    for i in range(3):
        work.place[i] += fade * (work.frame[POINT, i] - foot[i])
    return (1.0 - along / width) ** 2


@kernel
def _add_face_point(tube, nodes, segment, value, axes, force, forces):
    """Add what one point of a face takes off the elements' forces: force (ROWS, 3) in the local axes."""
    for row in range(ROWS):
        for k in range(3):
            for n in range(10):
                if tube.segment[nodes[n]] == segment and value[n] != 0.0:
                    for i in range(3):
                        forces[nodes[n], row, i] += value[n] * force[row, k] * axes[k, i]


@kernel
def _across(work, m, pull, loaded, at_front, force):
    """Fill `force` (ROWS, 3): (s' : e) m - (s' m) . grad u - t . h, the last for the traction t = s m.

    For J the elastic energy times m, less t . grad u. t is `pull`, or the element's own on loaded faces;
    the terms in m are left out at the front.
    """
    t0, t1, t2 = pull
    if loaded:
        t0, t1, t2 = _along(work.own[0], m), _along(work.own[1], m), _along(work.own[2], m)
    u = work.gradient
    for row in range(ROWS):
        is_j = row == MODES
        stress, h = (work.own, u) if is_j else (work.stress[row], work.h[row])
        energy = work.energy[0] if is_j else (stress * u).sum()
        for k in range(3):
            force[row, k] = -(t0 * h[0, k] + t1 * h[1, k] + t2 * h[2, k])
            if not at_front:
                force[row, k] += energy * m[k]
                for i in range(3):
                    for j in range(3):
                        if not is_j:
                            force[row, k] -= m[i] * stress[i, j] * u[j, k]

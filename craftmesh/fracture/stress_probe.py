"""The tangential stress on arcs around a front, and the direction in which it is largest."""

import numpy as np
import scipy

from craftmesh.fracture.fields import stresses
from craftmesh.fracture.tube import Tube
from craftmesh.mechanics.near_field import as_tensor
from craftmesh.mesh.front_curve import NEWTON_STEPS
from craftmesh.mesh.front_frames import Front
from craftmesh.mesh.integration import jacobians, shape_slopes, shape_values

# Angles in degrees: half width of the arc, which ends well before the lips (crack faces), step between
# probes, and step of the search for the largest stress.
WIDEST, STEP, FINE = 110.0, 5.0, 0.1
# Number of elements tried for each position, those with the nearest centres.
TRIED = 32
# Barycentric distances: an element contains a position that is at most INSIDE outside it. A position that
# is over OUTSIDE outside all elements is outside the body.
INSIDE, OUTSIDE = 1e-6, 0.05


def probed(tube: Tube, front: Front, s: np.ndarray, radius: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the angle (k,) in degrees of the largest tangential stress around the front, and the stress.

    s (k,): arc lengths on the front; radius (k,): of the arcs there, which are perpendicular to the front.
    Angles are from the binormal, positive towards the normal, and within WIDEST. NaN where 7 or fewer
    probes of an arc are inside the body. Source: the criterion of F. Erdogan and G. C. Sih, J. Basic Eng.
    85 (1963).
    """
    angles = np.radians(np.arange(-WIDEST, WIDEST + STEP / 2, STEP))
    points, _, normal, binormal = front.curve.frames(s)
    out = np.cos(angles)[:, None] * binormal[:, None] + np.sin(angles)[:, None] * normal[:, None]
    across = -np.sin(angles)[:, None] * binormal[:, None] + np.cos(angles)[:, None] * normal[:, None]
    places = (points[:, None] + radius[:, None, None] * out).reshape(-1, 3)
    stress, missed = _stresses(tube, places)
    across = across.reshape(-1, 3)
    pull = np.einsum("pi,pij,pj->p", across, stress, across)
    pull = np.where(missed > OUTSIDE, -np.inf, pull).reshape(len(s), -1)
    return _largest(angles, pull)


def _stresses(tube: Tube, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return stresses (k, 3, 3) at positions (k, 3), and how far (k,) these lie outside their elements.

    The element of a position is the first by distance of centres that contains it, or of the TRIED nearest
    the one that misses it least. Distances are in barycentric coordinates, 0 inside.
    """
    centres = tube.points[tube.tets[:, :4]].mean(axis=1)
    tried = scipy.spatial.KDTree(centres).query(places, k=range(1, min(TRIED, len(centres)) + 1))[1]
    element, share = tried[:, 0].copy(), np.zeros((len(places), 4))
    missed, left = np.full(len(places), np.inf), np.arange(len(places))
    for column in tried.T:
        found = _located(tube.points[tube.tets[column[left]]], places[left])
        outside = np.maximum(0.0, -found.min(axis=1))
        better = outside < missed[left]
        rows = left[better]
        element[rows], share[rows], missed[rows] = column[rows], found[better], outside[better]
        left = left[missed[left] > INSIDE]
    nodes, slope, grain = tube.tets[element], shape_slopes(share, 10), tube.grain[element]
    inverse = np.linalg.pinv(jacobians(tube.points, nodes, slope[:, None])[:, 0])
    heat = (shape_values(share) * tube.temperature[nodes]).sum(axis=1)
    gradient = tube.displacement[nodes].swapaxes(1, 2) @ slope @ inverse
    gradient -= heat[:, None, None] * tube.eigenstrain[grain]
    return stresses(as_tensor(tube.stiffness[grain]).reshape(-1, 9, 9), gradient), missed


def _located(nodes: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the barycentric coordinates (k, 4) of positions (k, 3) in elements with nodes at (k, 10, 3).

    By NEWTON_STEPS steps of Newton's method, of at most half an element; convergence is not checked.
    """
    share = np.full((len(places), 4), 0.25)
    for _ in range(NEWTON_STEPS):
        off = places - (shape_values(share)[:, None] @ nodes)[:, 0]
        jacobian = nodes.swapaxes(1, 2) @ shape_slopes(share, 10)
        step = (np.linalg.pinv(jacobian) @ off[:, :, None])[:, :, 0]
        step /= np.maximum(1.0, 2 * np.abs(step).max(axis=1, keepdims=True))
        share[:, 1:] += step
        share[:, 0] = 1 - share[:, 1:].sum(axis=1)
    return share


def _largest(angles: np.ndarray, pull: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the angle (k,) in degrees and the value (k,) of the largest stress in rows of `pull` (k, a).

    The stresses at angles (a,) are first fitted by smooth terms, because they jump between elements: by
    the terms of the first three powers of r in Williams' series. NaN if too few are finite.
    """
    fine = np.radians(np.arange(-WIDEST, WIDEST + FINE / 2, FINE))
    angle, value = np.full(len(pull), np.nan), np.full(len(pull), np.nan)
    for row, own in enumerate(pull):
        there = np.isfinite(own)
        if there.sum() > _terms(angles).shape[1]:
            weights = np.linalg.lstsq(_terms(angles[there]), own[there], rcond=None)[0]
            smooth = _terms(fine) @ weights
            smooth[(fine < angles[there].min()) | (fine > angles[there].max())] = -np.inf
            angle[row], value[row] = np.degrees(fine[np.argmax(smooth)]), smooth.max()
    return angle, value


def _terms(angles: np.ndarray) -> np.ndarray:
    """Return the values (a, 7) at angles (a,) of the terms that are fitted to the tangential stress."""
    waves = [wave(k * angles / 2) for k in (1, 3, 4) for wave in (np.cos, np.sin)]
    return np.stack([np.ones(len(angles)), *waves], axis=1)

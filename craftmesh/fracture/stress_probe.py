"""The tangential stress probed on arcs round a front: the direction in which it is largest."""

import numpy as np
from scipy.spatial import KDTree

from craftmesh.fracture.kernels.forces import Tube
from craftmesh.fracture.kernels.probe import fill_stresses
from craftmesh.mesh.front_frames import Front

# Degrees: the arc ends well before the lips; the step of the probes, that in which the largest is sought.
WIDEST, STEP, FINE = 110.0, 5.0, 0.1
# Elements that are tried for each place, by the distance of their centres.
TRIED = 32
# A place further out of all elements, in barycentric coordinates, lies outside the body.
OUTSIDE = 0.05


def probed(tube: Tube, front: Front, s: np.ndarray, radius: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the angle (k,) in degrees of the largest tangential stress at s (k,), and that stress.

    radius (k,): of the arcs, which lie square to the front; angles are from the binormal, positive towards
    the normal. NaN where all of an arc lies outside the body.
    Source: the maximum of the tangential stress, F. Erdogan, G. C. Sih, J. Basic Eng. 85 (1963).
    """
    angles = np.radians(np.arange(-WIDEST, WIDEST + STEP / 2, STEP))
    points, _, normal, binormal = front.curve.frames(s)
    out = np.cos(angles)[:, None] * binormal[:, None] + np.sin(angles)[:, None] * normal[:, None]
    across = -np.sin(angles)[:, None] * binormal[:, None] + np.cos(angles)[:, None] * normal[:, None]
    places = (points[:, None] + radius[:, None, None] * out).reshape(-1, 3)
    centres = tube.points[tube.tets[:, :4]].mean(axis=1)
    _, candidates = KDTree(centres).query(places, k=min(TRIED, len(centres)))
    stress, missed = np.zeros((len(places), 3, 3)), np.zeros(len(places))
    fill_stresses(
        tube.points, tube.displacement, tube.tets, tube.grain, tube.stiffness, tube.eigenstrain, places,
        candidates.reshape(len(places), -1), stress, missed,
    )  # fmt: skip
    across = across.reshape(-1, 3)
    pull = np.einsum("pi,pij,pj->p", across, stress, across)
    pull = np.where(missed > OUTSIDE, -np.inf, pull).reshape(len(s), -1)
    return _largest(angles, pull)


def _largest(angles: np.ndarray, pull: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return angle in degrees and value of the largest of pull (k, a), smoothed over angles (a,).

    Elements' stresses jump; the terms are those of the first three powers of r in Williams' series.
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
    """Return the terms (a, 7) of the tangential stress at angles (a,)."""
    waves = [wave(k * angles / 2) for k in (1, 3, 4) for wave in (np.cos, np.sin)]
    return np.stack([np.ones(len(angles)), *waves], axis=1)

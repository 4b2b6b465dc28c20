"""Crystal orientations: unit quaternions (w, x, y, z) of the active rotation, crystal to sample axes.

The matrix R of such a quaternion turns a vector's components in crystal axes into components in sample
axes. Bunge's matrix g goes from sample to crystal axes, so R = g^T.

scipy's Rotation gives the angle between two orientations. The conversions are written out here, because
Rotation rounds the last bit differently, which would change the decks of 445 of the 519 orientations of the
demo and the examples. The tests hold both to within 1e-12.
"""

import numpy as np
import scipy

from craftmesh.errors import CraftmeshError
from craftmesh.surface.side_data import spans_told, unit_hint
from craftmesh.types import TetMesh, Voxels

_ROUNDING = 1e-14  # a quaternion's length that differs from 1 by less counts as 1


def normalized(quaternions: np.ndarray) -> np.ndarray:
    """Return quaternions (..., 4) scaled to unit length, w >= 0; NaN for lengths of 0, NaN or infinity."""
    q = np.asarray(quaternions, float)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        length = np.linalg.norm(q, axis=-1, keepdims=True)
        length[np.abs(length - 1) < _ROUNDING] = 1  # so that a second normalization changes no bit
        q = np.where((length > 0) & np.isfinite(length), q / length, np.nan)
    return np.where(q[..., :1] < 0, -q, q)


def bunge_to_quaternion(angles: np.ndarray) -> np.ndarray:
    """Return (..., 4) quaternions of Bunge angles (..., 3): phi1, Phi, phi2 in radians, ZXZ.

    NaN angles give NaN. Source: H.-J. Bunge, Texture Analysis in Materials Science (1982), 2.1.
    """
    phi1, Phi, phi2 = np.moveaxis(np.asarray(angles, float), -1, 0)
    half_sum, half_difference = (phi1 + phi2) / 2, (phi1 - phi2) / 2
    cos, sin = np.cos(Phi / 2), np.sin(Phi / 2)
    parts = [
        cos * np.cos(half_sum),
        sin * np.cos(half_difference),
        sin * np.sin(half_difference),
        cos * np.sin(half_sum),
    ]
    return normalized(np.stack(parts, axis=-1))


def quaternion_to_bunge(quaternions: np.ndarray) -> np.ndarray:
    """Return Bunge angles (..., 3) of unit quaternions (..., 4): phi1, Phi, phi2 in radians, 0 to 2 pi.

    Where Phi is 0 or pi, phi1 and phi2 turn about the same axis, and each takes half of the angle.
    """
    w, x, y, z = np.moveaxis(np.asarray(quaternions, float), -1, 0)
    half_sum, half_difference = np.arctan2(z, w), np.arctan2(y, x)
    Phi = 2 * np.arctan2(np.hypot(x, y), np.hypot(w, z))
    phi1, phi2 = half_sum + half_difference, half_sum - half_difference
    return np.stack([phi1 % (2 * np.pi), Phi, phi2 % (2 * np.pi)], axis=-1)


def rodrigues_to_quaternion(vectors: np.ndarray) -> np.ndarray:
    """Return (..., 4) quaternions of Rodrigues vectors (..., 3): axis * tan(angle / 2)."""
    vectors = np.asarray(vectors, float)
    return normalized(np.concatenate([np.ones_like(vectors[..., :1]), vectors], axis=-1))


def matrix_to_quaternion(matrices: np.ndarray) -> np.ndarray:
    """Return (n, 4) quaternions of rotation matrices (n, 3, 3); NaN for matrices that are no rotations.

    R R^T may differ from the unit matrix by 0.01 per entry, as for a file with two decimals.
    """
    matrices = np.asarray(matrices, float)
    with np.errstate(over="ignore", invalid="ignore"):  # entries may be huge or NaN
        off = np.abs(matrices @ matrices.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2), initial=0.0)
    made = np.full((len(matrices), 4), np.nan)
    rotations = np.flatnonzero(off <= 0.01)
    rotations = rotations[np.linalg.det(matrices[rotations]) > 0]
    if len(rotations):
        turns = scipy.spatial.transform.Rotation.from_matrix(matrices[rotations])
        made[rotations] = turns.as_quat(scalar_first=True)
    return normalized(made)


def quaternion_to_matrix(quaternions: np.ndarray) -> np.ndarray:
    """Return rotation matrices (..., 3, 3); their columns are the crystal axes in the sample."""
    w, x, y, z = np.moveaxis(np.asarray(quaternions, float), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def angle_between(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the rotation angles (n,) in degrees between quaternions (n, 4) without NaN.

    No symmetry is applied.
    """
    turns_of = scipy.spatial.transform.Rotation.from_quat
    one, other = (turns_of(quaternions, scalar_first=True) for quaternions in (first, second))
    return np.degrees((one.inv() * other).magnitude())


def random_orientations(count: int, rng: np.random.Generator) -> np.ndarray:
    """Return (count, 4) quaternions spread uniformly over all rotations."""
    return normalized(rng.normal(size=(count, 4)))


def mean_by_grain(labels: np.ndarray, quaternions: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the mean orientation per label (g, 4), row = label, and the largest spread in degrees.

    The spread of a label is the root mean square of its quaternions' rotation angles from their mean.
    labels (n,) >= 0; quaternions (n, 4), NaN rows are ignored; labels without a row get NaN. Crystal
    symmetry is not applied: equivalent orientations mixed in one grain show as a large spread.
    Source: Markley et al., J. Guid. Control Dyn. 30 (2007): the mean is the main eigenvector of sum q q^T.
    """
    known = np.isfinite(quaternions).all(axis=1)
    labels, q = labels[known], quaternions[known]
    present, of, count = np.unique(labels, return_inverse=True, return_counts=True)
    moments = np.empty((len(present), 4, 4))
    for i in range(4):
        for j in range(4):
            moments[:, i, j] = np.bincount(of, q[:, i] * q[:, j], len(present))
    values, vectors = np.linalg.eigh(moments / count[:, None, None])
    mean = np.full((int(labels.max(initial=0)) + 1, 4), np.nan)
    mean[present] = normalized(vectors[:, :, 3])
    spread = 2 * np.arcsin(np.sqrt(np.clip(1 - values[:, 3], 0, 1)))
    return mean, float(np.degrees(spread.max(initial=0.0)))


def element_axes(mesh: TetMesh, voxels: Voxels) -> np.ndarray:
    """Return sample components (m, 6) of the crystal axes [100] and [010] of each element, NaN unknown.

    An element takes the axes of the voxel of its grain, with known orientation, that is nearest to its
    centroid; NaN if its grain has no such voxel. Raises CraftmeshError if the voxels' orientations were not
    kept, if the mesh reaches beyond the voxels by over a voxel, and if it is in another unit.
    """
    if voxels.voxel_orientations is None:
        raise CraftmeshError(
            "orientations is element, but the microstructure has only orientations of grains; import it "
            "with voxel_orientations, from a file that has orientations of voxels"
        )
    past = np.maximum(voxels.box[0] - mesh.box[0], mesh.box[1] - voxels.box[1])
    hint = unit_hint(mesh.box, voxels.box)
    if hint or (past > voxels.spacing).any():
        spans = spans_told(("the mesh goes", "the voxels"), mesh.box, voxels.box)
        raise CraftmeshError(
            f"orientations is element, but {spans}{hint}; expected the microstructure of this mesh"
        )
    middle = (mesh.points[mesh.tets[:, :4]].mean(axis=1) - voxels.origin) / voxels.spacing - 0.5
    within = np.clip(np.round(middle).astype(int), 0, np.array(voxels.labels.shape) - 1)
    known = np.isfinite(voxels.voxel_orientations).all(axis=3)
    boxes = scipy.ndimage.find_objects(np.where(known, np.maximum(voxels.labels, 0), 0))
    other = (voxels.labels[tuple(within.T)] != mesh.grain) | ~known[tuple(within.T)]
    for grain in np.unique(mesh.grain[other]).tolist():
        box = boxes[grain - 1] if grain <= len(boxes) else None
        rows = np.flatnonzero(other & (mesh.grain == grain))
        if box is not None:
            first = [part.start for part in box]
            places = np.argwhere((voxels.labels[box] == grain) & known[box]) + first
            near = scipy.spatial.cKDTree(places * voxels.spacing).query(middle[rows] * voxels.spacing)[1]
            within[rows], other[rows] = places[near], False
    matrices = quaternion_to_matrix(voxels.voxel_orientations[tuple(within.T)].astype(float))
    axes = matrices[:, :, :2].transpose(0, 2, 1).reshape(-1, 6)
    axes[other] = np.nan
    return axes

"""Bodies that a crack cuts in two, and bodies that still hold together."""

import numpy as np
import pytest

from craftmesh.cracks.body_separation import piece_cut_off
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.series import prescribed_crack
from craftmesh.types import Crack, Voxels

SHAPE = (12, 10, 16)


def body(labels=None):
    labels = np.ones(SHAPE, int) if labels is None else labels
    return Voxels(labels, np.array([1.0, 1.0, 0.5]), np.array([3.0, 0.0, -1.0]))


def sheet(through, normal):
    """Return a large square of two triangles through a point, square to the normal."""
    normal = np.array(normal) / np.linalg.norm(normal)
    u = np.cross(normal, [0.3, 1.0, 0.2])
    u /= np.linalg.norm(u)
    corners = [(-60, -60), (60, -60), (60, 60), (-60, 60)]
    points = np.array([np.array(through) + a * u + b * np.cross(normal, u) for a, b in corners])
    return Crack(points, np.array([[0, 1, 2], [0, 2, 3]]), (np.array([0, 1]),))


@pytest.mark.parametrize("normal", [(0, 0, 1), (1, 0, 0), (0, 1, 0), (0.3, -0.5, 1), (1, 1, 1), (-1, 0, 1)])
@pytest.mark.parametrize("through", [(9.0, 5.0, 3.0), (8.5, 4.5, 3.25), (9.17, 5.31, 2.9)])
def test_a_plane_cuts_off_the_voxels_behind_it(normal, through):
    """Planes through the voxels' corners, through their centres, and neither."""
    voxels = body()
    centres = voxels.origin + (np.argwhere(voxels.labels > 0) + 0.5) * voxels.spacing
    off = (centres - through) @ np.array(normal, float)
    # voxels whose centres are in the plane go to either side
    ahead, behind, within = (off > 1e-4).sum(), (off < -1e-4).sum(), (np.abs(off) <= 1e-4).sum()
    piece = piece_cut_off(voxels, sheet(through, normal))
    least = min(ahead, behind)
    assert least <= piece.volume / 0.5 <= least + within


@pytest.mark.parametrize(
    "options",
    [
        CrackOptions(shape="penny", centre=(9.0, 5.0, 3.0), radius=4.0),
        CrackOptions(shape="penny", centre=(9.0, 5.0, 3.0), radius=4.0, normal=(0.4, 0.1, 1.0)),
        CrackOptions(shape="through_edge", centre=(3.0, 5.0, 3.0), radius=10.5),
        CrackOptions(shape="through_edge", centre=(3.0, 5.0, 3.25), radius=10.5),
    ],
)
def test_a_ligament_of_a_voxel_holds(options):
    assert piece_cut_off(body(), prescribed_crack(body().box, options)) is None


def test_a_front_in_a_void_does_not_hold():
    labels = np.ones(SHAPE, int)
    labels[9:, :, 4:12] = 0  # a notch from the face x = 15, into which the crack of depth 10 runs
    edge = CrackOptions(shape="through_edge", centre=(3.0, 5.0, 3.0), radius=10.0)
    assert piece_cut_off(body(), prescribed_crack(body().box, edge)) is None
    piece = piece_cut_off(body(labels), prescribed_crack(body().box, edge))
    # two halves of the same size, the notch left out
    assert piece.volume == 0.5 * (12 * 10 * 8 - 3 * 10 * 4)
    assert abs(piece.middle[2] - 3.0) > 1.5


def test_bodies_that_were_apart_before_are_not_severed():
    labels = np.ones(SHAPE, int)
    labels[:, :, 8] = 0
    penny = CrackOptions(shape="penny", centre=(9.0, 5.0, 1.0), radius=3.0)
    assert piece_cut_off(body(labels), prescribed_crack(body().box, penny)) is None


def test_a_nib_between_a_crack_and_a_void_is_no_piece():
    labels = np.ones(SHAPE, int)
    labels[4:8, 4:8, 8:11] = -1
    labels[5:7, 5:7, 8] = 1  # four voxels, linked to the body on one side alone
    labels[5:7, 5:7, 7] = 1
    labels[4:8, 4:8, 8] = np.where(labels[4:8, 4:8, 8] == 1, 1, -1)
    penny = CrackOptions(shape="penny", centre=(9.0, 6.0, 3.0), radius=4.0)
    assert piece_cut_off(body(labels), prescribed_crack(body().box, penny)) is None

"""Grain ids of any size give the mesh of ids from 1, and take the memory of so many grains."""

import tracemalloc

import numpy as np
import pytest
from structured_box import structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.campaign.first_campaign import first_campaign
from craftmesh.mechanics.orientation import mean_by_grain
from craftmesh.mesh.quality import quality
from craftmesh.remeshing.remesh import remesh
from craftmesh.surface.patches import patches
from craftmesh.types import Voxels

FEW = np.array([0, 1, 2, 3, 4])
LARGE = np.array([0, 3, 2**20, 2**21 + 1, 2**31 - 2])  # a cube of the third is over 63 bits
# Bytes: the meshes here are of some 100 kB; a table up to the last id would be of 2 GB and more.
MOST_MEMORY = 2**26


def blocks(ids) -> Voxels:
    x, y, z = np.indices((6, 6, 6))
    labels = np.where(z < 3, np.where(x < 3, 1, 2), np.where(y < 2, 3, 4))
    return Voxels(ids[labels], (1, 1, 1), (0, 0, 0))


@pytest.fixture(scope="module")
def meshed():
    """Return the stages' results for few and large ids, and the peak of memory with the latter."""

    def stages(ids):
        voxels = blocks(ids)
        surface = remesh(voxels)[0]
        box, grain_tets = structured_box(
            (6, 6, 6), lambda places: voxels.labels[tuple(places.astype(int).T)]
        )
        mesh, _ = assemble(box, grain_tets)
        drift = quality(mesh, voxels)["volume_drift"]
        return surface, patches(surface).of_facet, mesh, drift, first_campaign(voxels, {})

    few = stages(FEW)
    tracemalloc.start()
    large = stages(LARGE)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return few, large, peak


def test_the_mesh_is_the_same_up_to_the_ids(meshed):
    surface, patch, mesh, drift, first = meshed[0]
    other, patches_of_other, other_mesh, other_drift, other_first = meshed[1]
    np.testing.assert_array_equal(surface.points, other.points)
    np.testing.assert_array_equal(LARGE[surface.sides], other.sides)
    np.testing.assert_array_equal(patch, patches_of_other)
    np.testing.assert_array_equal(mesh.points, other_mesh.points)
    np.testing.assert_array_equal(LARGE[mesh.grain], other_mesh.grain)
    assert list(drift["by_grain"].values()) == list(other_drift["by_grain"].values())
    assert first.sizing == other_first.sizing and first.grains == other_first.grains == 4


def test_memory_goes_by_the_number_of_grains(meshed):
    assert meshed[2] < MOST_MEMORY


def test_means_over_voxels_make_a_row_for_each_id_and_no_more():
    labels = np.array([5, 5, 900_000])
    quaternions = np.tile([1.0, 0, 0, 0], (3, 1))
    tracemalloc.start()
    mean, _ = mean_by_grain(labels, quaternions)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1.5 * mean.nbytes  # moments of all ids would be four times that
    np.testing.assert_allclose(np.abs(mean[[5, 900_000]]), quaternions[:2])
    assert np.isnan(np.delete(mean, [5, 900_000], axis=0)).all()

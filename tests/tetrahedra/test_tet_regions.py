"""Regions that facets part, and volumes, are those of groups of faces and of the tets one by one."""

import numpy as np
import pytest
from test_optimise_tets import random_ball

from craftmesh.mesh.tet_connectivity import group_triples, tet_volumes
from craftmesh.surface.connectivity import joined
from craftmesh.tetrahedra.kernels.tet_cavity import FACES, link_tets
from craftmesh.tetrahedra.kernels.tet_regions import find_facets, part_regions, sum_volumes


@pytest.mark.parametrize("seed", range(3))
def test_regions_end_at_facets_and_each_facet_is_found_on_its_faces(seed):
    points, tets, _ = random_ball(seed)
    faces = tets[:, FACES].reshape(-1, 3)
    groups = group_triples(faces)
    # all faces round one tet in three, which part it from the others, and some that bound nothing
    rng = np.random.default_rng(seed)
    rows = np.append(4 * np.arange(0, len(tets), 3)[:, None] + range(4), rng.integers(len(faces), size=9))
    chosen = np.unique(groups.index[rows])
    facets = np.sort(faces[groups.lead[chosen]], axis=1)
    facets = facets[np.lexsort(facets.T[::-1])]
    neighbours, found = np.empty((2, len(tets), 4), np.int64)
    region, room = np.empty((2, len(tets)), np.int64)
    link_tets(tets, len(tets), len(points), neighbours, np.empty(len(points), np.int64))
    find_facets(tets, facets, len(points), found)
    count = part_regions(neighbours, found, region, room)

    pairs = groups.pairs[~np.isin(groups.index[groups.pairs[:, 0]], chosen)] // 4
    assert (region == joined(len(tets), *pairs.T)).all()
    assert 1 < count == region.max() + 1
    on_facet = np.isin(groups.index, chosen)
    assert ((found.ravel() >= 0) == on_facet).all()
    assert (facets[found.ravel()[on_facet]] == np.sort(faces[on_facet], axis=1)).all()
    # facets of corners under a number alone
    find_facets(tets, facets, 20, found)
    assert ((found.ravel() >= 0) == (on_facet & (faces < 20).all(axis=1))).all()


def test_the_sum_of_volumes_counts_those_that_are_not_positive():
    points, tets, _ = random_ball(seed=2)
    volumes = tet_volumes(points, tets)
    assert sum_volumes(points, tets) == (pytest.approx(volumes.sum()), 0)
    tets[::7] = tets[::7][:, [1, 0, 2, 3]]
    volumes[::7] *= -1
    assert sum_volumes(points, tets) == (pytest.approx(volumes.sum()), len(volumes[::7]))

"""Distances from facets against a plain reference that tries them all."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_distances import triangle_distances

from craftmesh.surface.measure import nearest_facet


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1))
def test_the_nearest_of_all_facets_tells_distance_and_side(seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(12, 3)) * rng.choice([1.0, 8.0], (12, 1))
    facets = np.array([rng.choice(12, 3, replace=False) for _ in range(int(rng.integers(1, 25)))])
    # some places lie on corners, where several facets are equally near
    places = np.concatenate([4 * rng.normal(size=(30, 3)), points[:6]])
    _, distance, side = nearest_facet(places, points, facets)
    corners = points[facets]
    every = [triangle_distances(places, np.repeat(c[None], len(places), 0)) for c in corners]
    all_distances = np.stack(every)
    assert np.allclose(distance, all_distances.min(axis=0), atol=1e-9)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    height = np.einsum("fj,fqj->fq", normal, places[None] - corners[:, :1])
    near = all_distances <= all_distances.min(axis=0) + 1e-9
    ahead, behind = (near & (height > 0)).any(axis=0), (near & (height <= 0)).any(axis=0)
    assert np.where(side > 0, ahead, behind)[:30].all()

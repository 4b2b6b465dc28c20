"""Open-cell foams: density, one piece, struts of three voxels, voids that open to the air."""

import dataclasses

import numpy as np
import pytest
from scipy import ndimage
from scipy.spatial import cKDTree

from craftmesh.errors import CraftmeshError
from craftmesh.voxels.foam import largest_piece, struts
from craftmesh.voxels.generate import GenerateOptions, generate

FOAM = GenerateOptions(
    shape=(40, 40, 40), spacing=(0.5, 0.5, 0.5), origin=(3.0, 0.0, -2.0), grains=6, pores=8, seed=1
)


def material(**options):
    return generate(dataclasses.replace(FOAM, **options)).labels > 0


@pytest.mark.parametrize("density", (0.05, 0.2, 0.4))
def test_the_relative_density_is_met(density):
    # voxels at the same distance come in together: up to .011 at this size, over 20 seeds
    assert material(relative_density=density).mean() == pytest.approx(density, abs=0.015)


def test_foam_is_one_piece_and_open():
    labels = generate(FOAM).labels
    assert ndimage.label(labels > 0)[1] == 1
    assert labels.min() == 0
    assert len(np.unique(labels[labels > 0])) == FOAM.grains


def test_struts_thicken_towards_nodes_at_the_same_density():
    def thickest(**options):
        return ndimage.distance_transform_edt(material(**options)).max()

    assert thickest(strut_growth=6.0, strut_shape=5.0) > 1.2 * thickest(strut_growth=0.0)


def test_struts_are_three_voxels_thick_or_refused():
    inside = ndimage.binary_opening(
        material(relative_density=0.05), ndimage.generate_binary_structure(3, 1)
    )
    assert inside.any(axis=(1, 2)).all()
    with pytest.raises(CraftmeshError, match=r"relative_density 0\.03 .* under three voxels thick"):
        material(relative_density=0.03, pores=40)


def others_beside(cells):
    """How many cells other than its own each voxel touches with a face, voxel by voxel."""
    count = np.zeros(cells.shape, int)
    for at in np.ndindex(cells.shape):
        steps = [np.add(at, step * way) for step in np.eye(3, dtype=int) for way in (1, -1)]
        beside = [cells[tuple(to)] for to in steps if (to >= 0).all() and (to < cells.shape).all()]
        count[at] = len({*beside} - {cells[at]})
    return count


def test_material_is_within_the_radius_of_edges_and_thicker_at_nodes_by_its_definition():
    spacing, growth, shape = (0.5, 0.6, 0.4), 4.0, 2.0
    places = np.moveaxis(np.indices((16, 16, 16)), 0, -1) * spacing
    seeds = np.random.default_rng(7).uniform(0, 1, (9, 3)) * places.max(axis=(0, 1, 2))
    pores = cKDTree(seeds).query(places)[1]
    count, flat = others_beside(pores), places.reshape(-1, 3)
    b, e, q = (cKDTree(places[count >= least]).query(flat)[0] for least in (1, 2, 3))
    found = struts(pores, spacing, 0.45, growth, shape)
    assert (count >= 3).any()
    t = np.linspace(0.3, 2.0, 1701)
    shares = [((e <= r) | ((e * q < growth * r**2) & (e * b < shape * r**2))).mean() for r in t]
    radius = t[np.argmax(np.array(shares) >= 0.45)]
    expected = (e <= radius) | ((e * q < growth * radius**2) & (e * b < shape * radius**2))
    thin = (e <= radius).mean()
    assert thin < 0.4  # nodes and webs count
    expected = ndimage.binary_fill_holes(largest_piece(expected.reshape(pores.shape)))
    # voxels whose own radius lies within the steps of 1e-3 in which the radius was sought
    assert np.count_nonzero(found != expected) <= 0.005 * found.size


def test_the_largest_piece_is_kept_whatever_their_order():
    two = np.zeros((9, 4, 4), bool)
    two[0:2, :2, :2] = two[4:9, 1:4, 1:4] = True
    for flipped in (two, two[::-1], np.swapaxes(two, 0, 2)):
        assert largest_piece(flipped).sum() == 45 and not largest_piece(flipped)[~flipped].any()
    assert (largest_piece(two[4:]) == two[4:]).all() and not largest_piece(two & False).any()


def test_pores_without_nodes_have_even_struts_and_those_without_edges_are_refused():
    assert (material(pores=3, strut_growth=4.0) == material(pores=3, strut_growth=0.0)).all()
    for pores in (1, 2):
        with pytest.raises(CraftmeshError, match="^pores meet along no edge"):
            material(pores=pores)


def test_ends_of_struts_are_cut_off_across_the_axes_named():
    whole, cut = material(), material(cut_ends="xy")
    assert not cut[~whole].any()
    for axis in (0, 1):
        assert whole.take((0, -1), axis=axis).any()
        assert not cut.take((0, -1), axis=axis).any()
    assert cut.take((0, -1), axis=2).any()
    with pytest.raises(CraftmeshError, match="cut_ends is 'xw'; expected x, y, z"):
        material(cut_ends="xw")


def test_voids_that_cross_the_surface_are_air_and_others_keep_their_number():
    solid = dataclasses.replace(FOAM, pores=0)
    inner, corner = (13.0, 10.0, 8.0, 2.0), (3.0, 0.0, -2.0, 4.0)
    labels = generate(solid, np.array([inner, corner])).labels
    assert labels[20, 20, 20] == -1
    assert labels[0, 0, 0] == 0
    assert set(np.unique(labels)) == {-1, 0, *range(1, 7)}
    many = generate(
        dataclasses.replace(solid, voids=30, void_radius=1.0, void_radius_max=3.0, voids_cross=True)
    )
    assert ndimage.label(many.labels > 0)[1] == 1
    assert (many.labels == 0).any() and (many.labels < 0).any()


@pytest.mark.parametrize(
    ("options", "message"),
    (({"void_radius_max": 1.0}, "void_radius_max is 1; expected at least void_radius, 3"),),
)
def test_wrong_voids_are_refused(options, message):
    with pytest.raises(CraftmeshError, match=message):
        dataclasses.replace(FOAM, **options)

"""A crack whose mouth on a face of the box is shorter than any edge."""

from dataclasses import replace

import numpy as np
import pytest
from given_cracks import over_grid
from models import voronoi
from plain_distances import from_edges
from structured_box import structured_box

from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.insertion.insert import insert_crack
from craftmesh.remeshing.remesh import remesh
from craftmesh.sizing.sizing import Sizing, densify
from craftmesh.surface.check_surface import check_surface
from craftmesh.surface.front import front_edges
from craftmesh.surface.measure import total_area
from craftmesh.types import CRACK, Crack

SURFACE = remesh(voronoi(3, 10, (24, 22, 20)))[0]
CELLS = structured_box((3, 3, 3), lambda centres: np.ones(len(centres), int))[0]
BLOCK = replace(CELLS, points=CELLS.points * 8 / 3)


def tongue(width: float, bulge: float) -> Crack:
    """A crack from the face y = 0 on, long along x, whose narrow tip is `width` wide on the face x = 24.

    bulge: how far it is off a plane, so that a trace of it on a face is a chord.
    """
    x = np.linspace(4.0, 24.001, 60)
    half = width / 2 + (24.001 - x) * 0.35
    side = np.linspace(-1, 1, 25)
    u, s = np.meshgrid(x, side, indexing="ij")
    y = 11.3 + s * half[:, None]
    z = 10.2 + bulge * np.sin(0.5 * u) * np.cos(1.2 * (y - 11.3) + 0.8)
    return crack_from_triangles(*over_grid(u, y, z), None, SURFACE.box)


def sized(crack: Crack, l_min: float) -> Sizing:
    sources = np.concatenate([densify(crack.points[front], l_min / 2) for front in crack.fronts])
    return Sizing(l_min, 1.0, 3.0, 2.0, 8.0, 1.0, sources)


# an edge from one end of the mouth crossed the front at the other unseen, and what hung on it was lost
@pytest.mark.sampled(5)
@pytest.mark.parametrize("l_min", [0.6, 0.2])
@pytest.mark.parametrize("width", [0.03, 0.1, 0.3])
@pytest.mark.parametrize("bulge", [0.0, 0.3])
def test_a_tongue_comes_in_whole_with_its_narrow_mouth(l_min, width, bulge):
    crack = tongue(width, bulge)
    result, report = insert_crack(SURFACE, crack, sized(crack, l_min))
    assert check_surface(result) == []
    assert report["crack_off_times"] <= 1
    own = result.kind == CRACK
    given = total_area(crack.points, crack.triangles)
    assert total_area(result.points, result.facets[own]) == pytest.approx(given, rel=0.005)
    ends = np.concatenate([crack.points[front] for front in crack.fronts])
    off, _ = from_edges(ends, result.points, front_edges(result))
    assert off.max() < 0.1 * l_min


def shallow_lobe(slope: float, reach: float, width: float, x: float, y: float) -> Crack:
    """A crack down through the face z = 0 that rises again as a lobe `slope * reach` high over it."""
    across = np.linspace(-width / 2, width / 2, 13)
    down = np.linspace(1.0, 4.0, 13)[:-1]
    along, side = np.meshgrid(np.append(down, np.linspace(4.0, 6.0 + reach, 37)), across)
    lobe = slope * (reach * (1 - (2 * side / width) ** 2) - (6.0 + reach - along))
    share = np.clip(along - 4.0, 0.0, 1.0)
    rising = np.maximum(share * lobe - 0.5 * (1 - share), -0.5)
    height = np.where(along > 4.0, rising, np.interp(along, [1.0, 3.5], [2.0, -0.5]))
    return crack_from_triangles(*over_grid(side + 4 + x, along + y, height), None, BLOCK.box)


# all corners of a facet of the face lay on the lobe's mouth, so that the facet counted as the crack
@pytest.mark.parametrize(
    ("l_min", "lobe"),
    [
        (1.031, (0.136, 1.821, 3.071, -0.237, -0.447)),
        (0.760, (0.148, 1.564, 2.834, 0.124, -0.551)),
        (0.609, (0.139, 1.510, 2.623, -0.567, -0.527)),
    ],
)
def test_a_shallow_lobe_over_a_face_of_long_edges_comes_in(l_min, lobe):
    crack = shallow_lobe(*lobe)
    surface, numbers = insert_crack(BLOCK, crack, replace(sized(crack, l_min), l0=2.0, l_max=2.0))
    assert check_surface(surface) == []
    assert numbers["crack_off_times"] <= 1
    off = [from_edges(crack.points[ids], surface.points, front_edges(surface))[0] for ids in crack.fronts]
    assert len(off) == 2
    # front edges keep to the front within 0.02 of their target length, 2 here
    assert max(one.max() for one in off) < 0.04

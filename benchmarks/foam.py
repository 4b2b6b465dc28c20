"""Foams against porespy's: area of the struts' surface, at the same relative density and number of pores.

porespy (`pip install porespy`, not a dependency) thickens the edges of a Voronoi tessellation by one
radius. Our struts without growth towards nodes are the same kind of foam, made another way.
"""

import argparse
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from measure import print_table, write_json
from scipy import ndimage
from skimage.measure import marching_cubes, mesh_surface_area

from craftmesh.voxels.generate import generate
from craftmesh.voxels.options import GenerateOptions

COLUMNS = {
    "density": "relative density",
    "ours": "area by volume, times the edge",
    "plain": "the same, without growth",
    "porespy": "porespy",
    "off": "plain off %",
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--shape", type=int, default=120, help="voxels along an edge (default 120)")
    parser.add_argument("--pores", type=int, default=60)
    parser.add_argument("--seeds", type=int, default=3, help="how many to take the mean of")
    parser.add_argument("--densities", type=float, nargs="+", default=[0.1, 0.2, 0.3, 0.4])
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures to this file")
    arguments = parser.parse_args()
    shape, pores = (arguments.shape,) * 3, arguments.pores
    rows = []
    for density in arguments.densities:
        each = [surfaces(shape, pores, density, seed) for seed in range(arguments.seeds)]
        row = {key: float(np.mean([one[key] for one in each])) for key in each[0]}
        rows.append(row | {"off": 100 * (row["plain"] / row["porespy"] - 1)})
    write_json(arguments.json, {"rows": rows})
    print_table(rows, COLUMNS)


def surfaces(shape: tuple[int, int, int], pores: int, density: float, seed: int) -> dict[str, float]:
    """Return the surface of our foam, of ours without growth, and of porespy's at the latter's density."""
    try:
        from porespy.generators import voronoi_edges
    except ImportError:
        sys.exit("porespy is not installed: pip install porespy")
    options = GenerateOptions(shape=shape, pores=pores, relative_density=density, seed=seed)
    ours = generate(options).labels > 0
    plain = generate(replace(options, strut_growth=0.0)).labels > 0
    distance = ndimage.distance_transform_edt(
        voronoi_edges(list(shape), pores, flat_faces=False, seed=seed)
    )
    within = distance <= np.quantile(inner(distance), inner(plain).mean())
    found = {"density": density, "ours": surface(ours), "plain": surface(plain)}
    return found | {"porespy": surface(within)}


def inner(volume: np.ndarray) -> np.ndarray:
    """Return the middle of a volume, away from its faces, where porespy's outermost cells have no edges."""
    cut = tuple(slice(n // 5, n - n // 5) for n in volume.shape)
    return volume[cut]


def surface(material: np.ndarray) -> float:
    """Return the surface's area by volume, in the middle of the box, times the box's edge.

    Marching cubes of the voxels smoothed over one voxel, which takes the steps out alike for all.
    """
    smooth = inner(ndimage.gaussian_filter(material.astype(float), 1.0))
    points, facets, _, _ = marching_cubes(smooth, 0.5)
    return float(mesh_surface_area(points, facets) / smooth.size * len(material))


if __name__ == "__main__":
    main()

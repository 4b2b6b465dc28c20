"""Gradation of real and large volumes at near/far ratios of 2, 4 and 8, with and without a crack."""

from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
import yaml
from gradation_guards import box_breaches, ears, topology_breaches

from craftmesh import GradateOptions, Sizing, gradate
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.series import prescribed_crack
from craftmesh.insertion.insert import insert_crack
from craftmesh.remeshing.remesh import remesh
from craftmesh.sizing.sizing import densify
from craftmesh.stitching.stitch import stitch_grains
from craftmesh.surface.check_surface import check_surface
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.measure import facet_angles
from craftmesh.voxels.clean import CleanOptions, clean
from craftmesh.voxels.reading import read_voxels

ROOT = Path(__file__).resolve().parents[2]
STL = {"g26": "stl/g26.npz", "g100": "stl/g100.npz"}
IMAGES = {
    "al1050": "al1050/al1050_labdct_109x103x64.npz",
    "al6xn": "al6xn/prisms_al6xn_68x64x46.npz",
    "copper": "readers/copper_v7.dream3d",
}
VOLUMES = (*STL, *IMAGES)


@lru_cache(maxsize=1)
def surface_and_crack(name: str, data):
    """Return a volume's surface and the crack of its example, or a semicircle on y = 0."""
    if name in STL:
        return stitched(data / STL[name])
    config = yaml.safe_load((ROOT / "examples" / name / "config.yaml").read_text())
    voxels, _ = clean(read_voxels(data / IMAGES[name]), CleanOptions(**config.get("import", {})))
    (crack,) = config["cracks"].values()
    return remesh(voxels)[0], prescribed_crack(voxels.box, CrackOptions(**crack))


def stitched(path):
    data = np.load(path)
    triangles, sides = data["triangles"], data["sides"]
    grains = []
    for grain in np.unique(sides[sides > 0]).tolist():
        outward = triangles[sides[:, 0] == grain], triangles[sides[:, 1] == grain][:, ::-1]
        grains.append((grain, data["points"], np.concatenate(outward)))
    edge = data["labels"].shape[0]
    crack = CrackOptions(shape="penny", centre=(edge / 2, 0.0, edge / 2), radius=edge / 4)
    return stitch_grains(grains)[0], prescribed_crack(np.array([[0.0] * 3, [edge] * 3]), crack)


def mean_edge(surface) -> float:
    edges = unique_edges(surface.facets)[0]
    return float(np.linalg.norm(np.diff(surface.points[edges], axis=1)[:, 0], axis=1).mean())


def start(name: str, data, cracked: bool, ratio: float):
    """Return surface and sizing: l0 / 2 at the crack front (without crack: at one front node), then more.

    l0 is the input's mean edge; far away edges are `ratio` times as long as near.
    """
    surface, crack = surface_and_crack(name, data)
    l0 = mean_edge(surface)
    l_min = l0 / 2
    front = np.concatenate([densify(crack.points[ids], l_min / 2) for ids in crack.fronts])
    sources = front if cracked else front[len(front) // 2 : len(front) // 2 + 1]
    l_max = ratio * l_min
    sizing = Sizing(l_min, min(l0, l_max), l_max, 8 * l0, 16 * l0, 1.0, sources)
    if cracked:
        surface, _ = insert_crack(surface, crack, sizing)
    return surface, sizing


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [2, 4, 8])
@pytest.mark.parametrize("cracked", [True, False], ids=["crack", "whole"])
@pytest.mark.parametrize("name", VOLUMES)
def test_gradated_volumes_have_no_fault(name, cracked, ratio, shared_data):
    surface, sizing = start(name, shared_data, cracked, ratio)
    after, report = gradate(surface, sizing, GradateOptions())
    assert check_surface(after) == []
    assert topology_breaches(surface, after) + box_breaches(surface, after) == []
    assert ears(after) == 0
    smallest = facet_angles(after.points, after.facets).min(axis=1)
    # Measured: 6.3 and 7.7 degrees where cracks meet other surfaces (al1050, g100), 10 and more elsewhere;
    # at most 0.012% under 12 degrees.
    assert smallest.min() >= 3
    assert (smallest < 12).mean() <= 0.0005
    # Measured with restored volumes: at most 3.1e-4 (al6xn).
    assert report["drift"]["max"] < 0.001

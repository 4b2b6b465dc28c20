"""A crack that folds smoothly, from the verbs to the deck: lips, front, area and volumes."""

import numpy as np
import pytest
from given_cracks import bowl
from models import voronoi

from craftmesh.assembly.assemble import assemble
from craftmesh.cli import main
from craftmesh.gradation.gradate import GradateOptions, gradate
from craftmesh.io.npz import write_labels
from craftmesh.io.surface_files import read_triangles
from craftmesh.io.vtk import read_crack, read_surface, write_surface
from craftmesh.mesh.check_tets import check_tets
from craftmesh.mesh.second_order import raise_order
from craftmesh.remeshing.remesh import remesh
from craftmesh.sizing.sizing import SizingOptions, sizing_for
from craftmesh.surface.measure import area_vectors
from craftmesh.tetrahedra.options import TetrahedralizeOptions
from craftmesh.tetrahedra.tetrahedralize import tetrahedralize

VOXELS = voronoi(3, 5, (14, 14, 14))
CENTRE, RADIUS, DEGREES = np.array([7.1, 6.9, 7.2]), 4.0, 110.0
OPENING = np.radians(DEGREES)
LENGTHS = {"l_min": 0.8, "l0": 1.0, "l_max": 2.5, "r0": 2.0, "r1": 5.0}
FLAGS = [word for key, value in LENGTHS.items() for word in (f"--{key.replace('_', '-')}", str(value))]


def write_bowl(path):
    """A sphere's part up to 110 degrees from its lower pole, as text .off."""
    points, triangles = bowl(CENTRE, RADIUS, DEGREES, around=72, rings=30)
    lines = ["OFF", f"{len(points)} {len(triangles)} 0"]
    lines += [" ".join(map(repr, map(float, point))) for point in points.tolist()]
    lines += [" ".join(map(str, [3, *row])) for row in triangles.tolist()]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bowl")
    write_labels(folder / "labels.npz", VOXELS)
    write_surface(folder / "remeshed.vtp", remesh(VOXELS)[0])
    write_bowl(folder / "bowl.off")
    return folder


def crack(folder):
    given = ["--shape", "surface", "--file", str(folder / "bowl.off")]
    return main(["crack", str(folder / "labels.npz"), *given, "-o", str(folder / "crack.vtp")])


def stitch(folder):
    files = [str(folder / "remeshed.vtp"), "--crack", str(folder / "crack.vtp")]
    return main(["stitch", *files, *FLAGS, "-o", str(folder / "surface.vtp")])


@pytest.mark.slow
def test_a_bowl_is_meshed(folder):
    assert crack(folder) == stitch(folder) == 0
    given, surface = read_crack(folder / "crack.vtp"), read_surface(folder / "surface.vtp")
    sizing = sizing_for(surface, given.points[given.fronts[0]], SizingOptions(**LENGTHS))
    surface, _ = gradate(surface, sizing, GradateOptions(), crack=given)
    tets, _ = tetrahedralize(surface, sizing, TetrahedralizeOptions(fallback="none"))
    mesh, report = assemble(surface, tets)
    assert check_tets(mesh) == check_tets(raise_order(mesh)) == []
    assert report["cracks"] == report["fronts"] == 1
    # facets of 0.8 on a sphere of radius 4 are chords: 0.66 % less
    points, triangles = read_triangles(folder / "bowl.off")
    area = np.linalg.norm(area_vectors(points, triangles), axis=1).sum()
    assert report["crack_area"] == pytest.approx(area, rel=1e-2)
    lips = [mesh.outward_triangles(name) for name in ("CRACK_LIP_A", "CRACK_LIP_B")]
    assert len(lips[0]) == len(lips[1])
    vectors = [area_vectors(mesh.points, lip) for lip in lips]
    out = [
        np.einsum("ij,ij->i", mesh.points[lip].mean(axis=1) - CENTRE, v) for lip, v in zip(lips, vectors)
    ]
    # one lip looks to the sphere's centre all over, the other away from it
    assert (
        {int(np.sign(side).min()) for side in out} == {int(np.sign(side).max()) for side in out} == {1, -1}
    )
    front = mesh.points[mesh.node_sets["CRACK_FRONT"]] - CENTRE
    assert np.abs(np.hypot(front[:, 0], front[:, 1]) - RADIUS * np.sin(OPENING)).max() < 0.02 * 0.8
    assert np.abs(front[:, 2] + RADIUS * np.cos(OPENING)).max() < 0.02 * 0.8
    volume = {int(g): float((VOXELS.labels == g).sum()) for g in np.unique(VOXELS.labels)}
    corners = mesh.points[mesh.tets[:, :4]]
    edges = corners[:, 1:] - corners[:, :1]
    of_tet = np.linalg.det(edges) / 6
    for grain, wanted in volume.items():
        assert of_tet[mesh.grain == grain].sum() == pytest.approx(wanted, rel=2e-3)

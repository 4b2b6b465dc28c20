"""The mesh of a grown crack: what the crack leaves unchanged is kept to the bit, and the rest is sound."""

from dataclasses import replace

import numpy as np
import pytest
from deck_reader import elements_of, read_deck
from models import voronoi

from craftmesh.assembly.assemble import assemble
from craftmesh.cli import main
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.prepare import prepare_crack
from craftmesh.cracks.series import prescribed_crack
from craftmesh.deck.check_deck import check_deck
from craftmesh.deck.includes import mesh_file, read_deck_text
from craftmesh.gradation.gradate import GradateOptions, gradate
from craftmesh.insertion.insert import insert_crack
from craftmesh.io.mesh_formats import write_vtu
from craftmesh.io.vtk import read_tets, write_tets
from craftmesh.mesh.check import check
from craftmesh.mesh.second_order import as_elements
from craftmesh.mesh.shape_measures import is_flat, is_poor, shape_measures
from craftmesh.mesh.tet_connectivity import EDGE_CORNERS
from craftmesh.remeshing.remesh import remesh
from craftmesh.renewal.options import RenewOptions
from craftmesh.renewal.renew import StageOptions, history_of, renew_mesh
from craftmesh.renewal.whole import whole_of_mesh
from craftmesh.sizing.sizing import SizingOptions
from craftmesh.sizing.sources import Defects, sizing_around
from craftmesh.surface.measure import area_vectors, nearest_facet
from craftmesh.tetrahedra.options import TetrahedralizeOptions
from craftmesh.tetrahedra.volume import mesh_volume
from craftmesh.types import CRACK, INTERFACE

PLAIN = remesh(voronoi(3, 6, (26, 20, 26)))[0]
ALWAYS = StageOptions(renew=RenewOptions(reuse="always"))
# options of decks
LAYOUTS = {
    "quarter points": ["--quarter-points"],
    "cohesive": ["--element", "C3D4", "--cohesive", "all:stiffness=1e5"],
    "parts and includes": ["--element", "C3D4", "--style", "parts", "--includes"],
}


def penny(radius, centre=(13.0, 0.0, 13.2)):
    options = CrackOptions(shape="penny", centre=centre, normal=(0.1, 0.0, 1.0), radius=radius)
    crack = prepare_crack([prescribed_crack(PLAIN.box, options)], PLAIN.box, l_min=0.8)
    sizes = SizingOptions(l_min=0.8, l0=1.2, l_max=2.5, r0=1.5, r1=5)
    return crack, sizing_around(PLAIN, Defects(crack), sizes)


def area_of(mesh):
    triangles = mesh.outward_triangles("CRACK_LIP_A")
    return np.linalg.norm(area_vectors(mesh.points, triangles), axis=1).sum()


def off_boundaries(mesh, sizing):
    """Mean and 99 % of the distances of nodes on grain boundaries from PLAIN, in target lengths."""
    surface = whole_of_mesh(mesh, np.ones(len(mesh.points))).surface
    nodes = surface.facets[surface.kind == INTERFACE]
    nodes = surface.points[np.setdiff1d(nodes, surface.facets[surface.kind == CRACK])]
    reference = PLAIN.facets[PLAIN.kind == INTERFACE].astype(np.int64)
    off = nearest_facet(nodes, PLAIN.points, reference)[1] / sizing.at(nodes)
    return np.array([off.mean(), np.quantile(off, 0.99)])


def is_renewed(found):
    return not any("made from scratch" in warning for warning in found.warnings)


@pytest.fixture(scope="module")
def first():
    crack, sizing = penny(5.0)
    cut, _ = insert_crack(PLAIN, crack, sizing)
    fitted, _ = gradate(cut, sizing, crack=crack)
    volume, _ = mesh_volume(fitted, sizing)
    mesh, _ = assemble(volume.surface, volume.grain_tets, crack)
    return mesh, history_of(mesh, sizing)


@pytest.fixture(scope="module")
def renewed(first):
    crack, sizing = penny(5.6)
    return renew_mesh(*first, PLAIN, crack, sizing, ALWAYS)


@pytest.fixture(scope="module")
def third(renewed):
    crack, sizing = penny(6.2)
    return renew_mesh(renewed.mesh, renewed.history, PLAIN, crack, sizing, ALWAYS)


@pytest.fixture(scope="module")
def series(first, renewed, third, tmp_path_factory):
    """The files of three meshes, the meshes in them, and the maps of the second and third."""
    folder = tmp_path_factory.mktemp("series")
    paths = [folder / f"{number}.vtu" for number in range(3)]
    for path, mesh in zip(paths, (first[0], renewed.mesh, third.mesh)):
        write_tets(path, mesh)
    return paths, [read_tets(path) for path in paths], [renewed.numbers, third.numbers]


def test_what_stays_keeps_numbers_corners_and_bits(first, renewed):
    mesh, _ = first
    stays = np.flatnonzero(renewed.numbers.elements >= 0)
    assert len(stays) == renewed.report["renewed"]["elements_kept"] > 0.2 * len(mesh.tets)
    assert np.array_equal(renewed.numbers.elements[stays], stays)
    assert np.array_equal(renewed.mesh.tets[stays], mesh.tets[stays])
    nodes = np.flatnonzero(renewed.numbers.nodes >= 0)
    assert np.array_equal(renewed.mesh.points[nodes], mesh.points[nodes])
    assert np.array_equal(renewed.mesh.grain[stays], mesh.grain[stays])


def test_the_mesh_is_sound_and_holds_the_whole_crack(first, renewed):
    assert is_renewed(renewed)
    assert check(renewed.mesh) == []
    measures = shape_measures(renewed.mesh.points, renewed.mesh.tets)
    assert not (is_poor(measures) | is_flat(measures)).any()
    # half an ellipse of the tilted plane in the box; the promise is .5 % of the area
    assert area_of(renewed.mesh) == pytest.approx(np.pi * 5.6**2 / 2, rel=0.01)
    assert set(renewed.mesh.face_sets) == set(first[0].face_sets)
    assert len(renewed.history.lengths) == len(renewed.mesh.points)


def test_a_third_increment_goes_on_from_the_second(third):
    assert is_renewed(third)
    assert check(third.mesh) == []
    assert area_of(third.mesh) == pytest.approx(np.pi * 6.2**2 / 2, rel=0.01)


def test_grain_boundaries_stay_as_close_to_the_remeshed_surface_as_in_a_mesh_from_scratch(first, third):
    found = third
    for radius in (6.8, 7.4):
        crack, sizing = penny(radius)
        found = renew_mesh(found.mesh, found.history, PLAIN, crack, sizing, ALWAYS)
        assert is_renewed(found)
    assert (off_boundaries(found.mesh, sizing) < 1.1 * off_boundaries(first[0], penny(5.0)[1])).all()


def test_a_crack_elsewhere_replaces_the_old_one(first):
    crack, sizing = penny(5.0, (13.0, 0.0, 14.2))
    found = renew_mesh(*first, PLAIN, crack, sizing, ALWAYS)
    assert is_renewed(found)
    assert check(found.mesh) == []
    assert area_of(found.mesh) == pytest.approx(np.pi * 5.0**2 / 2, rel=0.01)
    assert set(found.mesh.face_sets) == set(first[0].face_sets)


def test_the_same_input_gives_the_same_bytes_for_any_number_of_workers(first, renewed):
    crack, sizing = penny(5.6)
    again = renew_mesh(*first, PLAIN, crack, sizing, ALWAYS, workers=2)
    assert again.mesh.points.tobytes() == renewed.mesh.points.tobytes()
    assert again.mesh.tets.tobytes() == renewed.mesh.tets.tobytes()


def test_without_optimise_the_part_is_not_optimised_either(first, renewed):
    mesh, history = first
    crack, sizing = penny(5.6)
    plain = replace(ALWAYS, tetrahedralize=TetrahedralizeOptions(optimise=False))
    found = renew_mesh(mesh, history, PLAIN, crack, sizing, plain)
    assert is_renewed(found) and check(found.mesh) == []
    assert renewed.report["meshing"]["smoothed"] and not found.report["meshing"]["smoothed"]
    before = set(map(tuple, mesh.points.tolist()))
    # the elements around the new ones, which optimising moves, are as before
    stay = [before.intersection(map(tuple, one.mesh.points.tolist())) for one in (renewed, found)]
    assert stay[0] < stay[1]
    new = [
        shape_measures(one.mesh.points, one.mesh.tets[one.mesh.element_sets["NEW"]])
        for one in (renewed, found)
    ]
    assert new[0][:, 1].mean() < new[1][:, 1].mean()


@pytest.mark.parametrize(
    ("options", "why"),
    [
        (replace(ALWAYS, gradate=GradateOptions(volume_tolerance=1e-9)), "the volume of grain"),
        (StageOptions(renew=RenewOptions(reuse="auto", most_renewed=0.01)), "most_renewed 0.01"),
        (ALWAYS, "mean aspect ratio"),
    ],
)
def test_what_cannot_be_renewed_is_made_anew_and_says_why(first, options, why):
    crack, sizing = penny(5.6)
    mesh, history = first
    history = history._replace(aspect_ratio=1.2) if why == "mean aspect ratio" else history
    found = renew_mesh(mesh, history, PLAIN, crack, sizing, options)
    assert why in found.warnings[0]
    told = found.report["renewed"]
    assert (told["share"], told["elements_kept"]) == (1.0, 0) and why in told["from_scratch"]
    assert len(found.mesh.element_sets["NEW"]) == len(found.mesh.tets)
    assert (found.numbers.elements == -1).all()
    assert check(found.mesh) == []


def test_new_are_the_elements_that_the_mesh_before_does_not_have(series, tmp_path):
    _, meshes, maps = series
    assert "NEW" not in meshes[0].element_sets
    for mesh, numbers in zip(meshes[1:], maps):
        kept = numbers.elements[numbers.elements >= 0]
        assert 0 < len(kept) < len(mesh.tets)
        assert np.array_equal(mesh.element_sets["NEW"], np.setdiff1d(np.arange(len(mesh.tets)), kept))
        write_vtu(tmp_path / "model.vtu", mesh)  # with triangles after the elements
        again = read_tets(tmp_path / "model.vtu")
        assert np.array_equal(again.element_sets["NEW"], mesh.element_sets["NEW"])


def test_quarter_points_are_at_the_new_front_only_and_kept_elements_have_their_mid_nodes(series):
    _, meshes, maps = series
    raised = [as_elements(mesh, "C3D10", quarter_points=True)[0] for mesh in meshes]
    for mesh in raised:
        ends = mesh.tets[:, EDGE_CORNERS]
        middle = mesh.points[ends].mean(axis=2)
        moved = (mesh.points[mesh.tets[:, 4:]] != middle).any(axis=2)
        at_front = np.isin(ends, mesh.node_sets["CRACK_FRONT"]).sum(axis=2) == 1
        assert moved.any() and not (moved & ~at_front).any()
    for old, new, numbers in zip(raised, raised[1:], maps):
        rows = np.flatnonzero(numbers.elements >= 0)
        same = new.points[new.tets[numbers.elements[rows]]] == old.points[old.tets[rows]]
        assert same.all()


@pytest.mark.parametrize("layout", LAYOUTS)
def test_decks_of_all_increments_are_valid_and_name_the_new_elements(series, layout, tmp_path, capsys):
    paths, meshes, maps = series
    decks = [tmp_path / f"model_{number}.inp" for number in range(3)]
    for path, deck in zip(paths, decks):
        assert main(["inp", str(path), "-o", str(deck), *LAYOUTS[layout]]) == 0, capsys.readouterr().err
        assert check_deck(deck) == []
    for deck, mesh in zip(decks, meshes):
        text = tmp_path / "whole.inp"
        text.write_text(read_deck_text(deck).text)
        assert mesh_file(deck).exists() == ("includes" in layout)
        _, sets = elements_of(read_deck(text))
        assert sets.get("NEW", []) == (mesh.element_sets.get("NEW", np.zeros(0, int)) + 1).tolist()
        assert any(name.startswith("COH_") for name in sets) == (layout == "cohesive")

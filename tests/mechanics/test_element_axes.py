"""Orientations of elements: kept by import, taken from the nearest voxel of the grain, read by CalculiX."""

import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from deck_reader import of_kind, read_deck
from structured_box import structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.cli import main
from craftmesh.deck.check_deck import check_deck
from craftmesh.errors import CraftmeshError
from craftmesh.io.model_tables import read_displacements
from craftmesh.io.npz import read_labels, write_labels
from craftmesh.io.vtk import write_tets
from craftmesh.mechanics.orientation import element_axes, quaternion_to_matrix, random_orientations

SHAPE = (4, 2, 2)
TURNS = random_orientations(16, np.random.default_rng(3)).astype(np.float32).reshape(*SHAPE, 4)
LABELS = 1 + (np.indices(SHAPE)[0] >= 2)


def imported(tmp_path, given):
    """Return a mesh of a file with quaternions of voxels, and what import keeps of it as labels.npz."""
    np.savez(tmp_path / "in.npz", labels=LABELS, spacing=np.ones(3), orientations=given)
    file, labels = str(tmp_path / "in.npz"), str(tmp_path / "labels.npz")
    assert main(["import", file, "--labels", labels, "--voxel-orientations"]) == 0
    mesh, _ = assemble(*structured_box(SHAPE, lambda c: 1 + (c[:, 0] >= 2)))
    write_tets(tmp_path / "volume.vtu", mesh)
    return mesh, read_labels(labels)


def test_elements_have_the_orientation_of_the_nearest_voxel_of_their_grain(tmp_path):
    given = TURNS.copy()
    given[3, 1, 1] = np.nan
    mesh, voxels = imported(tmp_path, given)
    axes = element_axes(mesh, voxels)
    middle = mesh.points[mesh.tets].mean(axis=1)
    for own, place in zip(axes, middle):
        at = tuple(np.floor(place).astype(int))
        turn = quaternion_to_matrix(TURNS[at].astype(float))
        if at == (3, 1, 1):
            near = [TURNS[k] for k in ((2, 1, 1), (3, 0, 1), (3, 1, 0))]
            known = [quaternion_to_matrix(q.astype(float))[:, :2].T.ravel() for q in near]
            assert min(np.abs(own - one).max() for one in known) < 1e-6
        else:
            assert own == pytest.approx(turn[:, :2].T.ravel(), abs=1e-6)
    moved = replace(voxels, labels=np.where(LABELS == 1, 2, 1))  # each element's grain is the other half
    centres = np.moveaxis(np.indices(SHAPE), 0, -1) + 0.5
    for own, place, grain in zip(element_axes(mesh, moved), middle, mesh.grain):
        candidates = np.argwhere((moved.labels == grain) & np.isfinite(given).all(axis=3))
        off = np.array([np.linalg.norm(centres[tuple(k)] - place) for k in candidates])
        near = [TURNS[tuple(k)] for k in candidates[off < off.min() + 1e-9]]
        known = [quaternion_to_matrix(q.astype(float))[:, :2].T.ravel() for q in near]
        assert min(np.abs(own - one).max() for one in known) < 1e-6
    with pytest.raises(CraftmeshError, match="import it with voxel_orientations"):
        element_axes(mesh, replace(voxels, voxel_orientations=None))
    for spacing, said in ((1e3, r"\(mm beside um\?\)"), (0.5, "the mesh goes from .*, the voxels from")):
        with pytest.raises(CraftmeshError, match=said):
            element_axes(mesh, replace(voxels, spacing=spacing * voxels.spacing))


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (ccx) is not installed")
def test_calculix_takes_them_as_it_does_a_grain_of_each_element(tmp_path):
    mesh, voxels = imported(tmp_path, TURNS)
    flags = ["--material", "cubic:168e3,121e3,75e3", "--element", "C3D4"]
    flags += ["--microstructure", str(tmp_path / "labels.npz")]
    found = []
    for name, extra in (("one", ["--orientations", "element"]), ("two", [])):
        deck = tmp_path / f"{name}.inp"
        assert main(["inp", str(tmp_path / "volume.vtu"), *flags, *extra, "-o", str(deck)]) == 0
        assert check_deck(deck) == []
        done = subprocess.run(["ccx", "-i", name], cwd=tmp_path, capture_output=True, text=True, timeout=60)
        assert "*ERROR" not in done.stdout and done.returncode == 0
        found.append(read_displacements(tmp_path / f"{name}.frd")[1])
        grains = np.arange(1, len(mesh.tets) + 1)
        places = tuple(np.floor(mesh.points[mesh.tets].mean(axis=1)).astype(int).T)
        turns = np.concatenate([np.full((1, 4), np.nan), TURNS[places].astype(float)])
        write_tets(tmp_path / "volume.vtu", replace(mesh, grain=grains))
        write_labels(tmp_path / "labels.npz", replace(voxels, orientations=turns, voxel_orientations=None))
    assert sum(len(rows) - 1 for _, rows in of_kind(read_deck(tmp_path / "one.inp"), "DISTRIBUTION")) == 96
    # .frd has 6 digits
    assert np.abs(found[0] - found[1]).max() < 1e-5 * np.abs(found[0]).max()


def test_what_has_no_axes_of_elements_is_refused(tmp_path, capsys):
    imported(tmp_path, TURNS)
    base = ["inp", str(tmp_path / "volume.vtu"), "--orientations", "element", "-o", str(tmp_path / "m.inp")]
    known = ["--microstructure", str(tmp_path / "labels.npz")]
    for flags, said in (
        ([], "give --microstructure"),
        ([*known, "--user-material", "oxford"], "a material"),
    ):
        assert main([*base, *flags]) == 1
        assert said in capsys.readouterr().err.replace("one material", "a material")

"""Folders of surfaces that are no body together: refused in one line, or said in the report."""

import json

import numpy as np
import pytest
import trimesh
from grain_folders import write_grain_folder
from structured_box import structured_box
from surface_writer import write_triangles

from craftmesh.cli import main
from craftmesh.errors import CraftmeshError
from craftmesh.io.surface_files import SUFFIXES
from craftmesh.io.vtk import read_surface
from craftmesh.stitching.stitch import stitch_grains
from craftmesh.surface.connectivity import compact

BRICKS = ((3, 3, 3), lambda c: 1 + (c[:, 0] > 1).astype(int) + 2 * (c[:, 1] > 1) + 4 * (c[:, 2] > 1))


def bricks():
    """Eight grains of a cube of 3 x 3 x 3 at (4, 5, 6): (id, points, triangles), normals outward."""
    surface, _ = structured_box(*BRICKS, origin=(4.0, 5, 6))
    grains = {}
    for grain in surface.grains.tolist():
        behind, ahead = (surface.sides == grain).T
        facets = np.concatenate([surface.facets[behind & ~ahead], surface.facets[ahead & ~behind][:, ::-1]])
        grains[grain] = compact(surface.points, facets)[:2]
    return grains


def written(folder, grains, suffix):
    folder.mkdir()
    for grain, (points, triangles) in grains.items():
        write_triangles(folder / f"grain_{grain}{suffix}", points, triangles)
    return folder


def stitched(folder, capsys):
    """Return the exit status of `craftmesh stitch`, the line of its error, and its report."""
    output, report = folder.parent / "o.vtp", folder.parent / "o.json"
    status = main(["stitch", str(folder), "-o", str(output), "--report", str(report)])
    error = capsys.readouterr().err
    assert status == 0 or (error.count("\n") == 1 and not output.exists() and not report.exists())
    return status, error, json.loads(report.read_text()) if status == 0 else {}


def moved(grains, grain, by):
    return grains | {grain: (grains[grain][0] + by, grains[grain][1])}


def scaled(grains, grain, factor):
    return grains | {grain: (grains[grain][0] * factor, grains[grain][1])}


def joined(grains, ids):
    points, triangles, shift = [], [], 0
    for grain in ids:
        points.append(grains[grain][0])
        triangles.append(grains[grain][1] + shift)
        shift += len(points[-1])
    rest = {grain: surface for grain, surface in grains.items() if grain not in ids}
    return rest | {ids[0]: (np.concatenate(points), np.concatenate(triangles))}


def inside(grains):
    """A ninth grain, a small copy of the first within it."""
    points, triangles = grains[1]
    return grains | {9: (points.mean(axis=0) + 0.3 * (points - points.mean(axis=0)), triangles)}


REFUSED = {
    "two grains in one surface": (lambda g: joined(g, (3, 4)), r"grain 3 has .* on each other"),
    "overlap": (lambda g: moved(g, 8, (-0.9, -0.8, -0.7)), r"surfaces of grains .*8.* intersect near \["),
    "a wide gap": (lambda g: moved(g, 8, (2.4, 0.1, 0.3)), r"grains 8 .* share no facet|grains 8 lie off"),
    "inside another": (inside, r"grains 9 lie inside grain 1, near \["),
    "far off": (
        lambda g: moved(g, 5, (0, 900, 0)),
        r"grains 5 lie off .* from \[4.0, 905.0, 7.0\] .* the others from \[4.0, 5.0, 6.0\]",
    ),
    "mm beside um": (lambda g: scaled(g, 2, 1e-3), r"grains 2 .* 1000 times as small \(mm beside um\?\)"),
    "um beside mm": (lambda g: scaled(g, 7, 1e3), r"grains 7 .* 1000 times as large \(um beside mm\?\)"),
    "um beside m": (
        lambda g: scaled(g, 7, 1e6),
        r"grain 1 has 12 of its 12 facets.*, 9000000.0",
    ),
    "a little off": (lambda g: moved(g, 8, (-0.1, 0, 0)), "grains 4, 6, 7, 8 do not match"),
    "open": (lambda g: g | {6: (g[6][0], g[6][1][2:])}, "grains 6 are not closed"),
    "one file twice": (lambda g: g | {9: g[4]}, "grains 2, 4, 9 share one facet near"),
}


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("fault", REFUSED)
def test_grains_that_are_no_body_together_are_refused(fault, suffix, tmp_path, capsys):
    spoil, said = REFUSED[fault]
    folder = written(tmp_path / "s", spoil(bricks()), suffix)
    with pytest.raises(CraftmeshError, match=said):
        raise CraftmeshError(stitched(folder, capsys)[1])


SAID = {
    "inside out": (lambda g: g | {3: (g[3][0], g[3][1][:, ::-1])}, "the facets of grains 3 looked inwards"),
    "a missing neighbour": (
        lambda g: {k: s for k, s in g.items() if k != 5},
        "facets to the outside off the box.* ids without one: 5|ids without one: 5",
    ),
}


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("fault", SAID)
def test_what_is_guessed_is_said(fault, suffix, tmp_path, capsys):
    spoil, said = SAID[fault]
    status, _, report = stitched(written(tmp_path / "s", spoil(bricks()), suffix), capsys)
    assert status == 0
    with pytest.raises(CraftmeshError, match=said):
        raise CraftmeshError(" ".join(report["notes"]))


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_hidden_files_and_files_without_a_number_are_left_out(suffix, tmp_path, capsys):
    folder = written(tmp_path / "s", bricks(), suffix)
    (folder / f"._grain_1{suffix}").write_bytes(b"\0\5\26\7")
    write_triangles(folder / f"all{suffix}", *bricks()[1])
    status, _, report = stitched(folder, capsys)
    assert (status, report["grains"]) == (0, 8)
    assert report["notes"] == [f"all{suffix} left out: no grain id ends the name"]


def several_solids(path, grains):
    """Write a file with a solid per grain, by trimesh."""
    bodies = {f"grain {k}": trimesh.Trimesh(*surface, process=False) for k, surface in grains.items()}
    if path.suffix == ".stl":
        text = "".join(
            trimesh.exchange.stl.export_stl_ascii(body).replace("solid ", f"solid {name}", 1) + "\n"
            for name, body in bodies.items()
        )
        path.write_text(text)
    elif path.suffix == ".obj":
        text, shift = [], 1
        for name, body in bodies.items():
            text += [f"o {name}", *(f"v {x} {y} {z}" for x, y, z in body.vertices.tolist())]
            text += [f"f {a} {b} {c}" for a, b, c in (body.faces + shift).tolist()]
            shift += len(body.vertices)
        path.write_text("\n".join(text))
    else:
        path.write_bytes(trimesh.Scene(bodies).export(file_type=path.suffix[1:]))


@pytest.mark.parametrize("suffix", [".stl", ".obj", ".3mf"])
def test_a_file_of_several_solids_never_is_one_grain(suffix, tmp_path, capsys):
    grains = bricks()
    (tmp_path / "s").mkdir()
    several_solids(tmp_path / "s" / f"all_1{suffix}", {1: grains[1], 8: grains[8]})  # they touch in a point
    assert f"all_1{suffix}: contains 2 solids" in stitched(tmp_path / "s", capsys)[1]


def test_pieces_of_a_grain_and_groups_of_its_patches():
    first, second = bricks()[1], bricks()[1]
    apart = joined({1: first, 2: (second[0] + 5, second[1])}, (1, 2))
    _, report = stitch_grains([(1, *apart[1])])
    assert report["notes"][-1] == "grains 1 consist of pieces that do not touch"
    hollow = joined(
        {1: first, 2: (0.3 * second[0] + 0.7 * second[0].mean(axis=0), second[1][:, ::-1])}, (1, 2)
    )
    _, report = stitch_grains([(1, *hollow[1])])
    assert report["voids"] == 1 and "pieces" not in " ".join(report["notes"])


def test_slivers_may_go_and_walls_may_not(tmp_path, capsys):
    grains = bricks()
    points, triangles = grains[1]
    ridge = np.array([[0, 0, 0.0], [0, 1e-8, 0], [1e-8, 0, 0]])  # a flap without area at a corner
    thin = (
        np.concatenate([points, points[:1] + ridge]),
        np.concatenate([triangles, len(points) + np.array([[0, 1, 2], [0, 2, 1]])]),
    )
    status, _, report = stitched(written(tmp_path / "s", grains | {1: thin}, ".obj"), capsys)
    assert (status, report["degenerate_facets_dropped"]) == (0, 2)
    assert len(read_surface(tmp_path / "o.vtp").grains) == 8


def test_exported_grains_come_back_without_a_note(tmp_path, capsys):
    surface, _ = structured_box(*BRICKS)
    write_grain_folder(tmp_path / "s", surface)
    status, _, report = stitched(tmp_path / "s", capsys)
    assert (status, report["notes"], report["folded_facets_dropped"]) == (0, [], 0)

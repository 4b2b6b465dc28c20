"""Random cracks: the drawing of cases, every check on inputs of known answer, the rows and the summary."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"
sys.path.insert(0, str(BENCHMARKS))

from trials import (  # noqa: E402
    chain,
    crack_checks,
    deck_file,
    distances,
    drawing,
    one_seed,
    sheets,
    summary,
    tet_checks,
    verdict,
    volumes,
    wedges,
)

from craftmesh.cracks.height_parts import height_parts  # noqa: E402
from craftmesh.cracks.series import crack_area  # noqa: E402
from craftmesh.cracks.sheets import cracks_from_triangles  # noqa: E402
from craftmesh.mesh.shape_measures import shape_measures  # noqa: E402
from craftmesh.sizing.sizing import Sizing, SizingOptions  # noqa: E402
from craftmesh.types import Surface, Voxels  # noqa: E402

SMALL = (12, 14)


@pytest.fixture(autouse=True)
def no_measured_volumes(monkeypatch):
    monkeypatch.setattr(volumes, "MEASURED", {name: Path("/nowhere") for name in volumes.MEASURED})


@pytest.mark.parametrize("seed", range(5))
def test_a_drawn_case_is_small_and_the_same_again(seed):
    case, again = drawing.draw(seed, SMALL), drawing.draw(seed, SMALL)
    assert np.array_equal(case.voxels.labels, again.voxels.labels)
    assert np.array_equal(case.sheet.points, again.sheet.points)
    assert case.sizes == again.sizes and case.words == again.words
    assert case.sizes.l_min <= case.sizes.l0 <= case.sizes.l_max
    assert drawing.estimated_tets(case.voxels, case.sheet, case.sizes) <= drawing.MOST_TETS
    assert np.isfinite(case.sheet.points).all()


def test_seeds_reach_every_kind(monkeypatch):
    monkeypatch.setattr(drawing, "estimated_tets", lambda *_: 0)
    monkeypatch.setattr(drawing, "draw_volume", lambda *_: (solid(), "cells"))
    drawn = [drawing.draw(seed, SMALL).kinds for seed in range(100, 180)]
    assert {kinds["relief"] for kinds in drawn} == set(sheets.RELIEFS)
    assert len({kinds["place"] for kinds in drawn}) >= 7


@pytest.mark.parametrize("angle", [0.0, np.pi / 2])
@pytest.mark.parametrize("shape", ["disc", "strip"])
def test_triangles_of_a_kinked_sheet_follow_its_crease(shape, angle):
    turn = np.radians(60)
    relief = sheets.Relief(sheets._kink((1.3, angle), turn), (1.3, angle), "kinked")
    if shape == "disc":
        sheet = sheets.disc((6.0, 4.0), relief, 0.5)
    else:
        sheet = sheets.strip(lambda _, v: 5 + 0 * v, 3.0, 10.0, relief, 0.5)
    _, normals = sheets.samples(sheet)
    assert set(np.round(np.abs(normals[:, 2]), 9)) == {1.0, round(np.cos(turn), 9)}


@pytest.mark.parametrize("kind", ["wavy", "fractal"])
def test_edges_of_l_min_can_follow_a_rough_sheet(kind):
    l_min = 0.5
    for seed in range(10):
        relief = sheets.draw_relief(np.random.default_rng(seed), kind, 6.0, l_min)
        u, v = np.meshgrid(*[np.linspace(-6, 6, 200)] * 2)
        off = (
            relief.height(u + l_min / 2, v) / 2 + relief.height(u - l_min / 2, v) / 2 - relief.height(u, v)
        )
        assert 0 < np.abs(off).max() < 0.05 * l_min


def test_distances_are_those_of_dense_samples():
    rng = np.random.default_rng(1)
    points, corners = rng.normal(size=(40, 3)), rng.normal(size=(40, 3, 3))
    s, t = (x.ravel() for x in np.meshgrid(*[np.linspace(0, 1, 100)] * 2))
    weights = np.stack([1 - s, s * (1 - t), s * t], axis=1)
    dense = np.einsum("nk,mkd->mnd", weights, corners)
    by_samples = np.linalg.norm(dense - points[:, None], axis=2).min(axis=1)
    exact = distances.pair_distance(points, corners)
    # 100 samples a side are up to 0.06 apart on these triangles, whose edges are up to 6 long
    assert (exact <= by_samples + 1e-12).all() and np.abs(exact - by_samples).max() < 4e-2
    nearest = np.linalg.norm(dense.reshape(-1, 3)[None] - points[:5, None], axis=2).min(axis=1)
    assert np.abs(distances.to_sheet(points[:5], corners, 0.0) - nearest).max() < 4e-2
    line = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0]])
    at = np.array([[0.5, -2.0, 0], [2.0, 2.0, 0]])
    assert np.allclose(distances.to_polylines(at, (line,)), [2, np.sqrt(2)])


def test_area_within_the_box_cuts_triangles_at_its_planes():
    square = np.array(
        [[[-1.0, -1, 0.5], [3, -1, 0.5], [3, 3, 0.5]], [[-1, -1, 0.5], [3, 3, 0.5], [-1, 3, 0.5]]]
    )
    assert distances.area_within(square, np.array([[0.0, 0, 0], [1, 2, 1]])) == pytest.approx(2)
    assert distances.area_within(square + [0, 0, 1], np.array([[0.0, 0, 0], [1, 2, 1]])) == 0


def wedge_prism(degrees: float, inside: int, outside: int) -> Surface:
    """A prism whose sharpest edge has the given angle; facets with normals out of `inside`."""
    tip = np.array([[0, 0, 0], [1, 0, 0], [np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0]])
    points = np.concatenate([tip, tip + [0, 0, 1]])
    facets = [[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]]
    return Surface(points, facets, [[inside, outside]] * 8, [0] * 8)


@pytest.mark.parametrize("degrees", [0.5, 5.0, 40.0])
def test_wedges_are_measured_inside_grains_alone(degrees):
    edges, angle, grain = wedges.wedges(wedge_prism(degrees, 1, 0))
    assert angle.min() == pytest.approx(degrees) and grain[angle.argmin()] == 1
    assert set(edges[angle.argmin()]) == {0, 3}
    _, angle, _ = wedges.wedges(wedge_prism(degrees, -1, 2))
    # the void's own wedges do not count, the grain around it has 360 degrees less them
    assert angle.min() >= 180 and angle.max() == pytest.approx(360 - degrees)


def test_only_wedges_sharper_than_the_limit_and_the_input_are_made():
    sizing = Sizing(1, 1, 1, 1, 1, 1, np.zeros((1, 3)))
    surfaces = {degrees: wedge_prism(degrees, 1, 0) for degrees in (4, 8, 20)}
    made = {
        (a, b): wedges.check_wedges(surfaces[a], surfaces[b], sizing)["wedges_made"]
        for a in surfaces
        for b in surfaces
    }
    assert [pair for pair, count in made.items() if count] == [(8, 4), (20, 4), (20, 8)]


def test_a_place_beside_the_end_of_a_long_edge_has_its_wedge():
    plain = wedge_prism(8, 1, 0)
    surface = replace(plain, points=plain.points * [1, 1, 20])
    edges, angle, _ = wedges.wedges(surface)
    ends = surface.points[[0, 3]]
    outward = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    places = ends[1] + np.array([[-1.0], [1.9], [2.1]]) * outward
    sizing = Sizing(1, 1, 1, 1, 1, 1, np.zeros((1, 3)))
    least = wedges.local_least(surface, edges, angle, places, sizing)
    assert least == pytest.approx([8.0, 8.0, 360.0])


def test_measures_of_tets_are_those_of_the_package():
    corners = np.random.default_rng(2).normal(size=(200, 4, 3))
    found = tet_checks.measures(corners)
    theirs = shape_measures(corners.reshape(-1, 3), np.arange(800).reshape(-1, 4))
    for column, name in enumerate(("volume", "aspect", "least", "largest", "shape")):
        # both round; arccos loses half of the digits near 0 and 180 degrees
        assert np.allclose(found[name], theirs[:, column], rtol=1e-6, atol=1e-5), name


def solid(edge: int = 12) -> Voxels:
    return Voxels(np.ones((edge,) * 3, np.int32), np.ones(3), np.zeros(3))


def penny_case(centre, normal, radius: float = 3.0) -> drawing.Drawn:
    """A plain case: two grains and a penny."""
    labels = np.ones((12, 12, 12), np.int32)
    labels[:, :, 7:] = 2
    frame = drawing.draw_one(0, SMALL)  # only its other fields
    normal = np.array(normal, float) / np.linalg.norm(normal)
    axis = np.cross(normal, [0.3, 0.5, 0.8])
    axis /= np.linalg.norm(axis)
    rows = np.stack([axis, np.cross(normal, axis), normal])
    relief = sheets.Relief(lambda u, v: 0 * u)
    sheet = sheets.placed(sheets.disc((radius, radius), relief, 0.5), np.array(centre, float), rows)
    prescribed = drawing.CrackOptions(
        shape="penny", centre=tuple(centre), normal=tuple(normal), axis=tuple(axis), radius=radius
    )
    sizes = SizingOptions(l_min=0.7, l0=1.0, l_max=2.0, r0=3.0, r1=6.0)
    return replace(
        frame,
        voxels=Voxels(labels, np.ones(3), np.zeros(3)),
        sheet=sheet,
        prescribed=prescribed,
        sizes=sizes,
        element="C3D10",
        quarter_points=False,
    )


@pytest.mark.parametrize(
    "centre, normal, right",
    [
        ((6, 6, 5), (0, 1, 1), None),
        ((6, 0, 5), (0, 0, 1), None),
        ((6, 6, 0.1), (0, 0, 1), "in a face"),
        ((6, 6, 0.6), (0, 0.04, 1), "tilted to a face by under 3 degrees"),
        ((6, 6, 30), (0, 0, 1), "outside the material"),
        ((0.06, 6, 0.06), (1, 0, 1), "a sliver at an edge"),
    ],
)
def test_refusals_are_right_outside_and_in_faces_alone(centre, normal, right):
    assert crack_checks.may_be_refused(penny_case(centre, normal), 0.7) == right


@pytest.fixture(scope="module")
def meshed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("chain")
    case = penny_case((6, 0, 5), (0.2, 0, 1))
    return case, chain.run_chain(case, folder)


def row_of(case, made, deck) -> dict:
    """The row of a deck that is given instead of the one in the file."""
    l_min = case.sizes.l_min
    return (
        {"outcome": "deck", "may_be_refused": None, "warnings": []}
        | crack_checks.check_crack(case, deck, l_min)
        | crack_checks.check_inserted(case, made.inserted, l_min)
        | wedges.check_wedges(made.inserted, made.gradated, made.sizing)
        | tet_checks.check_tets(case, deck, made.inserted, made.gradated, made.sizing)
    )


def test_a_plain_penny_is_without_fault_and_each_fault_is_found(meshed):
    case, made = meshed
    assert made.refusal is None
    deck = deck_file.read_deck(made.deck)
    sound = row_of(case, made, deck)
    assert verdict.faults_of(sound) == {}
    assert sound["front_edges"] > 8 and sound["drift_mean_pct"] < 2

    less = sound | {"area_off_pct": 0.9, "l_min": 0.7}  # 0.02 l_min squared are 0.0098
    assert verdict.faults_of(less | {"area_given": 1.0, "area": 0.991}) == {}
    assert list(verdict.faults_of(less | {"area_given": 10.0, "area": 9.91})) == ["area"]

    nodes = np.unique(crack_checks.front_edges(deck))
    moved = deck.points.copy()
    moved[nodes[len(nodes) // 2]] += 0.05 * case.sizes.l_min
    assert "front" in verdict.faults_of(row_of(case, made, replace(deck, points=moved)))

    lifted = deck.points.copy()
    lip = np.setdiff1d(deck.triangles("CRACK_LIP_A"), nodes)
    lifted[lip[len(lip) // 2]] += 0.2 * case.sizes.l_min * np.array([0, 0, 1])
    found = verdict.faults_of(row_of(case, made, replace(deck, points=lifted)))
    assert {"crack nodes", "conformity"} <= set(found)

    flat = deck.points.copy()
    inner = np.setdiff1d(
        deck.corners, np.concatenate([deck.triangles(name).ravel() for name in deck.surfaces])
    )
    tet = deck.corners[np.isin(deck.corners[:, 0], inner)][0]
    flat[tet[0]] = flat[tet[1:]].mean(axis=0)
    assert {"flat", "inverted"} & set(verdict.faults_of(row_of(case, made, replace(deck, points=flat))))

    fewer = {name: rows for name, rows in deck.surfaces.items() if name != "XMIN"}
    assert "conformity" in verdict.faults_of(row_of(case, made, replace(deck, surfaces=fewer)))


def test_commands_that_redo_a_case_name_files_that_were_written(tmp_path):
    given = replace(penny_case((6, 0, 5), (0, 0, 1)), prescribed=None, with_front=True)
    lines = chain.write_inputs(given, tmp_path)
    for name in ("labels.npz", "islands.json", "crack_in.stl", "front_in.csv"):
        assert (tmp_path / name).is_file() and any(name in line for line in lines)


def test_the_summary_counts_outcomes_and_names_faults():
    kinds = {"volume": "cells", "crack": "disc", "relief": "flat", "place": "face"}
    rows = [
        kinds
        | {
            "seed": 1,
            "outcome": "refusal",
            "may_be_refused": "in a face",
            "stage": "crack",
            "message": "m",
        },
        kinds
        | {"seed": 2, "outcome": "refusal", "may_be_refused": None, "stage": "stitch", "message": "n"},
        {"seed": 3, "outcome": "crash", "faults": {"crash": "ended"}},
    ]
    rows = [row | {"faults": row.get("faults", None) or verdict.faults_of(row)} for row in rows]
    text = summary.markdown(rows)
    assert "| **all** | 3 | 0 | 1 | 1 | 1 | 2 |" in text
    assert "| refused | insertion | 1 | 2 |" in text and "| crash | any | 1 | 3 |" in text


def test_a_hang_is_a_row_and_the_run_resumes(tmp_path):
    row = one_seed.run_apart(3, one_seed.Trial(), 0.05)
    assert row["outcome"] == "crash" and "0.05 s" in row["faults"]["crash"]
    target = tmp_path / "rows.json"
    target.write_text(json.dumps(row) + "\n")
    command = [
        sys.executable,
        str(BENCHMARKS / "random_cracks.py"),
        "3",
        "3",
        "--json",
        str(target),
        "--resume",
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert "| crash | any | 1 | 3 |" in done.stdout
    assert len(target.read_text().splitlines()) == 1


@pytest.mark.parametrize("kind", ["pair", "overhang", "boundaries"])
def test_further_kinds_of_cracks_are_cracks_for_the_chain(kind):
    case, again = drawing.draw(3, SMALL, kind), drawing.draw(3, SMALL, kind)
    assert case.kinds["crack"] == kind and np.array_equal(case.sheet.points, again.sheet.points)
    assert drawing.estimated_tets(case.voxels, case.sheet, case.sizes) <= drawing.MOST_TETS
    assert len(case.parts) == (2 if kind == "pair" else 0)
    if kind == "overhang":
        assert len(height_parts(case.sheet.points, case.sheet.triangles)[0]) > 1
    if kind == "boundaries":
        assert case.prescribed.boundaries and len(case.sheet.fronts)
    else:
        crack = cracks_from_triangles(case.sheet.points, case.sheet.triangles, None, case.voxels.box)
        assert crack_area(crack) > 0 and case.prescribed is None


@pytest.mark.slow
def test_a_pair_may_be_refused_where_one_of_it_may():
    case = penny_case((6, 6, 5), (0.2, 0, 1))
    beside = sheets.placed(case.sheet, np.array([0.0, 0.0, 99.0]), np.eye(3))
    assert crack_checks.may_be_refused(case, case.sizes.l_min) is None
    both = replace(case, parts=(case.sheet, beside))
    assert crack_checks.may_be_refused(both, case.sizes.l_min) == "outside the material"
    over = sheets.placed(case.sheet, np.array([0.0, 0.0, 0.1 * case.sizes.l_min]), np.eye(3))
    along = replace(case, parts=(case.sheet, over))
    assert crack_checks.may_be_refused(along, case.sizes.l_min) == "cracks along each other"
    higher = sheets.placed(case.sheet, np.array([0.0, 0.0, 0.5 * case.sizes.l_min]), np.eye(3))
    assert crack_checks.may_be_refused(replace(case, parts=(case.sheet, higher)), case.sizes.l_min) is None

"""Every meeting of a crack with box, grains, voids and other cracks, from voxels to a deck that is checked.

The checks are those of the random cracks, which share no code with the stages: front nodes within 0.02
l_min, facets within 0.05, area within 0.5 %, lips in pairs, every free face in a named surface.
"""

import re
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))

from trials import chain, crack_checks, deck_file, one_seed, verdict  # noqa: E402
from trials.drawing import Drawn  # noqa: E402
from trials.sheets import Relief, Sheet, disc, placed  # noqa: E402

from craftmesh.cracks.options import CrackOptions  # noqa: E402
from craftmesh.cracks.prescription import frame_along  # noqa: E402
from craftmesh.io.vtk import read_tets  # noqa: E402
from craftmesh.mechanics.model import elastic_model  # noqa: E402
from craftmesh.mechanics.model_options import ModelOptions  # noqa: E402
from craftmesh.mechanics.rigid_body_supports import rigid_motions  # noqa: E402
from craftmesh.mesh.check_tets import check_tets  # noqa: E402
from craftmesh.mesh.tet_connectivity import bodies  # noqa: E402
from craftmesh.sizing.sizing import SizingOptions  # noqa: E402
from craftmesh.types import BOX_PLANES, Voxels  # noqa: E402

EDGE = 14
L_MIN = 0.7
SIZES = SizingOptions(l_min=L_MIN, l0=1.0, l_max=2.5, r0=2.0, r1=6.0)
# The largest drift of a grain was 0.18 %, that of a crack at 2 degrees to a boundary from a face on.
DRIFT = 0.5  # percent
# The least dihedral angle was 8.0 degrees, in the wedge of 5 degrees between a crack and a boundary.
LEAST_ANGLE = 6.0


def volume(label_of) -> Voxels:
    x, y, z = np.indices((EDGE,) * 3) + 0.5
    return Voxels((label_of(x, y, z) + 0 * x).astype(np.int32), (1.0, 1.0, 1.0), (0.0, 0.0, 0.0))


def in_ball(x, y, z):
    return (x - 7) ** 2 + (y - 7) ** 2 + (z - 7) ** 2 < 9


ONE = volume(lambda x, y, z: 1)
TWO = volume(lambda x, y, z: np.where(z < 7, 1, 2))
TRIPLE = volume(lambda x, y, z: np.where(x > 7, 3, np.where(z < 7, 1, 2)))
QUADRUPLE = volume(lambda x, y, z: np.where(z < 7, np.where(x < 7, 1, 2), np.where(y < 7, 3, 4)))
EMBEDDED = volume(lambda x, y, z: np.where(in_ball(x, y, z), 2, 1))
VOID = volume(lambda x, y, z: np.where(in_ball(x, y, z), -1, 1))
LATH = volume(lambda x, y, z: np.where((abs(x - 7) < 2) & (abs(y - 7) < 2), 2, 1))


def ellipse(centre, normal, semi_axes) -> tuple[Sheet, CrackOptions]:
    """A plane crack, as a sheet for the checks and as options for the chain."""
    axis = np.eye(3)[np.abs(normal).argmin()]
    sheet = placed(
        disc(semi_axes, Relief(lambda u, v: 0 * u), L_MIN),
        np.array(centre, float),
        frame_along(np.array(normal, float), axis),
    )
    where = {name: tuple(map(float, x)) for name, x in (("centre", centre), ("normal", normal))}
    return sheet, CrackOptions(shape="ellipse", axis=tuple(axis.tolist()), semi_axes=semi_axes, **where)


def tilted(degrees):
    return np.sin(np.radians(degrees)), 0.0, np.cos(np.radians(degrees))


def penny(centre, normal, radius):
    return ellipse(centre, normal, (radius, radius))


LEVEL = (0, 0.2, 1)
# The volume, the crack, and where the ends of its fronts lie; closed fronts have none.
PLANE = {
    "one face": (ONE, penny((7, 0, 7), LEVEL, 4.0), "YMIN YMIN"),
    "two faces": (ONE, penny((0, 0, 7), LEVEL, 4.5), "XMIN YMIN"),
    "three faces": (ONE, penny((0, 0, 0), (1, -0.5, -0.3), 5.0), "YMIN ZMIN"),
    "a corner exactly": (ONE, penny((2, 2, 0.5), (1, -1, 0), 5.0), "XMIN_YMIN ZMIN"),
    "along an edge exactly": (ONE, penny((0, 0, 7), (1, -1, 0), 4.0), "XMIN_YMIN XMIN_YMIN"),
    "front through an edge exactly": (ONE, penny((3, 4, 7), (0, 0, 1), 5.0), "XMIN YMIN"),
    "front touches a face": (ONE, penny((7, 4, 7), (0, 0, 1), 4.0), "YMIN YMIN"),
    "front leaves through two far faces": (ONE, penny((0, 0, 7), (0, 0.1, 1), 16.0), "XMAX YMAX"),
    "fronts from face to far face": (
        ONE,
        ellipse((0, 7, 7.3), (0, 0.1, 1), (20.0, 5.0)),
        "XMAX XMAX XMIN XMIN",
    ),
    **{f"boundary at {a} degrees": (TWO, penny((7, 7, 7), tilted(a), 4.0), "") for a in (90, 30, 10, 5, 2)},
    **{
        f"boundary at {a} degrees, from a face on": (TWO, penny((7, 0, 7.2), tilted(a), 4.0), "YMIN YMIN")
        for a in (30, 10, 5, 2)
    },
    "in a boundary": (TWO, penny((7, 7, 7), (0, 0, 1), 4.0), ""),
    "in a boundary, from a face on": (TWO, penny((7, 0, 7), (0, 0, 1), 4.0), "YMIN YMIN"),
    "partly in a boundary": (TRIPLE, penny((7, 7, 7), (0, 0, 1), 4.0), ""),
    "across a triple line": (TRIPLE, penny((7, 7, 7), (0.1, 1, 0.2), 4.0), ""),
    "front through a triple line": (TRIPLE, penny((11, 7, 7), (0, 1, 0), 4.0), "XMAX XMAX"),
    "through a quadruple point": (QUADRUPLE, penny((7, 7, 7), (0.3, 0.5, 1), 4.0), ""),
    "front through a quadruple point": (QUADRUPLE, penny((9, 7, 4), (-0.5, 1, -1 / 3), 13**0.5), ""),
    "through an embedded grain": (EMBEDDED, penny((7, 7, 7), LEVEL, 4.5), ""),
    "front in an embedded grain": (EMBEDDED, penny((9, 7, 7), LEVEL, 3.0), ""),
    "through a void": (VOID, penny((7, 7, 7.2), LEVEL, 5.0), ""),
    "front ends on a void": (VOID, penny((10, 7, 7), LEVEL, 2.5), "VOID_1 VOID_1"),
    "severs a grain": (LATH, penny((7, 7, 7), LEVEL, 4.5), ""),
}


def two(*cracks) -> Sheet:
    """Discs of 200 chords as one sheet, whose pieces are the cracks."""
    sheets = []
    for centre, normal, radius in cracks:
        around = np.linspace(0, 2 * np.pi, 201)
        rim = radius * np.column_stack([np.cos(around), np.sin(around), 0 * around])
        i = np.arange(1, 201)
        triangles = np.column_stack([0 * i, i, i % 200 + 1])
        flat = Sheet(np.concatenate([[[0, 0, 0]], rim[:-1]]), triangles, (rim,), True)
        axis = np.eye(3)[np.abs(normal).argmin()]
        sheets.append(placed(flat, np.array(centre, float), frame_along(np.array(normal, float), axis)))
    first, second = sheets
    return Sheet(
        np.concatenate([first.points, second.points]),
        np.concatenate([first.triangles, second.triangles + len(first.points)]),
        first.fronts + second.fronts,
        False,
    )


PAIRS = {
    "cross": (
        two(((7, 7, 7.3), (0, 0.1, 1), 4), ((7.3, 7, 7), (1, 0.1, 0.05), 3)),
        "CRACK CRACK CRACK CRACK",
    ),
    "cross at the fronts": (
        two(((7, 7, 7.3), (0, 0.1, 1), 4), ((10.5, 7, 7.3), (1, 0, 0.2), 2)),
        # the first crack ends 0.09 l_min from the second one's front and cuts it at both crossings
        "CRACK CRACK CRACK CRACK",
    ),
    "cross in their mouths": (
        two(((7, 0, 7.3), (0, 0.1, 1), 5), ((7.3, 0, 7), (1, 0, 0.1), 4)),
        "CRACK CRACK YMIN YMIN YMIN YMIN",
    ),
    "touch at their fronts": (two(((4, 7, 7.3), (0, 0, 1), 3), ((10, 7, 7.3), (0, 0, 1), 3)), ""),
    "all but touch": (two(((4, 7, 7.3), (0, 0, 1), 3), ((10.025, 7, 7.3), (0, 0, 1), 3)), ""),
    "pass one another": (two(((5, 7, 6.3), (0, 0.1, 1), 3), ((9, 7, 7.8), (0, 0.1, 1), 3)), ""),
    "lie 0.7 l_min apart": (two(((7, 7, 7.2), (0, 0.1, 1), 4), ((7, 7, 7.7), (0, 0.1, 1), 3)), ""),
}


def judged_row(folder, voxels, sheet, options) -> tuple[dict, deck_file.DeckFile]:
    case = Drawn(0, voxels, sheet, options, False, SIZES, "C3D4", False, {"volume": "of a meeting"})
    made = chain.run_chain(case, folder)
    row = {"seed": 0, **one_seed.checked(case, made)}
    assert row["outcome"] == "deck", row["message"]
    if one_seed.JUDGE.exists():
        row |= one_seed.judge(made.deck)
    return row, deck_file.read_deck(made.deck)


# The given front that is not there, in l_min: what grazes a face, or another front, within 0.018 l_min ends
# there, to either side of where circles of 4 to 6 l_min touch.
TAKEN = {"front touches a face": 0.45 * L_MIN, "touch at their fronts": 0.4}


def holds(row, name=""):
    assert verdict.faults_of(row) == {}
    # a chord of two l_min on a circle of 5 l_min is 0.1 off
    assert row["front_missing"] < TAKEN.get(name, 0.1)
    assert row["drift_large_pct"] < DRIFT and row["dihedral_min"] > LEAST_ANGLE and row["flat"] == 0


def front_ends(deck) -> list[str]:
    """The faces on which the ends of open fronts lie, sorted: where one front edge ends alone."""
    edges = crack_checks.front_edges(deck)
    nodes, count = np.unique(edges, return_counts=True)
    low, high = deck.points.min(axis=0), deck.points.max(axis=0)
    sides = np.column_stack([low, high]).ravel()
    found = []
    for node in nodes[count == 1]:
        at = np.repeat(deck.points[node], 2) == sides
        names = [name for name, there in zip(BOX_PLANES, at) if there]
        names += [name for name in deck.surfaces if "VOID" in name and node in deck.triangles(name)]
        found.append("_".join(names) or "CRACK")
    return sorted(found)


@pytest.mark.sampled(7)
@pytest.mark.parametrize("name", PLANE)
def test_a_crack_meets_what_is_in_its_way(name, tmp_path):
    voxels, (sheet, options), ends = PLANE[name]
    row, deck = judged_row(tmp_path, voxels, sheet, options)
    holds(row, name)
    assert front_ends(deck) == sorted(ends.split())
    edges = deck.points[crack_checks.front_edges(deck)]
    length = np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1)
    # 0.9 where the front is a circle of 6 l_min inside grains; in a boundary, whose edges are halved, 0.6
    assert 0.55 < np.median(length) / L_MIN < 1.05
    # 0.43 beside a face where the crack lies in a boundary or almost, in all others over 0.45; where the
    # front touches a face the gap under it goes to nothing, and edges to 0.12 l_min, collapsed under 0.75
    least = 0.09 if name == "front touches a face" else 0.4
    assert least < length.min() / L_MIN and length.max() / L_MIN < 1.1


@pytest.mark.sampled(4)
@pytest.mark.parametrize("name", PAIRS)
def test_cracks_meet_each_other(name, tmp_path):
    sheet, ends = PAIRS[name]
    row, deck = judged_row(tmp_path, TWO, sheet, None)
    holds(row, name)
    assert front_ends(deck) == sorted(ends.split())


def test_cracks_in_one_plane_that_overlap_are_one(tmp_path):
    """Area and front are those of both discs' union: what of a front lies in the other crack is none."""
    sheet = two(((5, 7, 7.3), (0, 0.1, 1), 3), ((9, 7, 7.3), (0, 0.1, 1), 3))
    row, deck = judged_row(tmp_path, TWO, sheet, None)
    assert set(verdict.faults_of(row)) == {"front missing", "area"}  # against discs that are apart
    assert row["front_node"] < verdict.FRONT and front_ends(deck) == []
    edges = deck.points[crack_checks.front_edges(deck)]
    arc = 4 * 3 * (np.pi - np.arccos(2 / 3))
    assert np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1).sum() == pytest.approx(arc, rel=0.005)
    corners = deck.points[deck.lip("A")]
    spokes = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lens = 2 * 9 * np.arccos(2 / 3) - 4 * 5**0.5
    # chords of 0.55 on a radius of 3 cut off 0.6 % of a disc
    assert np.linalg.norm(spokes, axis=1).sum() / 2 == pytest.approx(18 * np.pi - lens, rel=0.01)


def test_cracks_that_close_the_way_between_two_faces_leave_two_fronts(tmp_path):
    """Half discs from XMIN and XMAX in one plane, which overlap: the fronts end on YMIN and YMAX."""
    sheet = two(((0, 7, 7.3), (0, 0.1, 1), 8), ((14, 7, 7.3), (0, 0.1, 1), 8))
    row, deck = judged_row(tmp_path, TWO, sheet, None)
    assert set(verdict.faults_of(row)) == {"front missing", "area"}
    assert row["front_node"] < verdict.FRONT
    assert front_ends(deck) == ["YMAX", "YMAX", "YMIN", "YMIN"]


SEVERED = {
    "the whole section": (penny((7, 7, 7.3), LEVEL, 15.0), 14**3 / 2 - 0.3 * 14**2),
    "obliquely": (penny((7, 7, 7.3), (0.5, 0.1, 1), 15.0), 14**3 / 2 - 0.3 * 14**2),
    "a corner": (penny((1, 1, 1), (1, 1, 1), 4.0), 4.5),
}


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", SEVERED)
def test_a_crack_that_severs_the_specimen_is_told_and_both_bodies_are_held(name, tmp_path):
    (sheet, options), volume_off = SEVERED[name]
    case = Drawn(0, TWO, sheet, options, False, SIZES, "C3D4", False, {"volume": "of a meeting"})
    made = chain.run_chain(case, tmp_path)
    assert made.refusal is None
    said = " ".join(made.warnings)
    assert "the mesh is 2 separate bodies" in said
    assert float(re.search(r"volume ([\d.]+) around", said)[1]) == pytest.approx(volume_off, rel=2e-3)
    mesh = read_tets(tmp_path / "volume.vtu")
    assert "CRACK_FRONT" not in mesh.node_sets and {"CRACK_LIP_A", "CRACK_LIP_B"} <= set(mesh.face_sets)
    assert check_tets(mesh) == []
    if one_seed.JUDGE.exists():
        assert one_seed.judge(made.deck) == {"judged": []}
    for sides in ("free", "rollers"):
        assert no_body_is_free(mesh, elastic_model(mesh, ModelOptions(element="C3D4", sides=sides))[0].load)


def no_body_is_free(mesh, load) -> bool:
    """Tell whether the supports leave no body of the mesh a rigid motion."""
    body = bodies(mesh)
    for number in np.unique(body):
        nodes = np.unique(mesh.tets[body == number])
        motions = rigid_motions(mesh.points[nodes])
        rows = [motions[np.isin(nodes, fixed.nodes), fixed.axis] for fixed in (*load.held, *load.moved)]
        if np.linalg.matrix_rank(np.concatenate(rows)) < 6:
            return False
    return True


@pytest.mark.parametrize("inside, faults", [(0.01, set()), (0.03, {"front missing"})])
def test_a_front_on_a_face_may_be_missing(inside, faults):
    counts = "front_edges wedges_made flat_unforced inverted grains_lost grains_unknown faces_over_two "
    counts += "free_faces_unnamed named_faces_not_free lips_unpaired nodes_unused"
    row = dict.fromkeys(counts.split(), 0) | {"outcome": "deck", "warnings": [], "drift_large_pct": 0.0}
    row |= {"may_be_refused": "the front runs along a face", "front_inside": inside}
    assert set(verdict.faults_of(row)) == faults

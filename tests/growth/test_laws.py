"""Laws of da/dN and blocks of loads against closed forms of the life of a penny, and the ends of growth."""

import json
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from edge_crack import write_edge_crack
from hypothesis import given
from hypothesis import strategies as st
from structured_box import structured_box
from test_cycles import at

from craftmesh.assembly.assemble import assemble
from craftmesh.cli import main
from craftmesh.errors import CraftmeshError
from craftmesh.growth.extension import UNSTABLE, YIELDS, kinks_and_extensions
from craftmesh.growth.front_points import FrontPoints
from craftmesh.growth.load_history import rainflow_blocks
from craftmesh.growth.net_section import section_area
from craftmesh.growth.options import GrowthOptions
from craftmesh.growth.rates import laws_of, local_rates, opening_level
from craftmesh.io.front_csv import read_front, write_front
from craftmesh.io.npz import write_labels
from craftmesh.io.vtk import read_tets
from craftmesh.mesh.front_frames import front_frames
from craftmesh.types import Voxels

STRESS, FIRST, SHARE = 100.0, 1.0, 0.05
NASGRO = {
    "C": 2e-12,
    "n": 3.2,
    "p": 0.25,
    "q": 1.0,
    "threshold": 80.0,
    "c": 1.5,
    "below": 0.1,
    "K_c": 2000.0,
}


def text_of(law):
    return "nasgro:" + ",".join(map(str, law.values())) + ",2,0.3"


def rate(law, driving, ratio=0.0):
    driving = np.atleast_1d(np.array(driving, float))
    laws = local_rates(
        laws_of(GrowthOptions(rates=(law,))), np.ones(len(driving), int), np.zeros(len(driving))
    )
    return laws.rate(at(driving, ratio))


def front_of(size, last=None, **known):
    """A penny of that radius under STRESS: K_I = 2 s (a / pi)^(1/2) (Sneddon 1946)."""
    k = np.outer(np.full(5, 2 * STRESS * np.sqrt(size / np.pi)), [1.0, 0.0, 0.0])
    return FrontPoints.of(k, size, last=last, **known)


def grown(steps, **options):
    """Return the last front of a penny that grows from radius FIRST in steps of SHARE of it."""
    size, last = FIRST, None
    for _ in range(steps):
        last = kinks_and_extensions(front_of(size, last), GrowthOptions(share=SHARE, **options))[1]
        size += last.step
    return last


def integral(power, size):
    """Return the integral of a^power from FIRST to `size`."""
    return (size ** (power + 1) - FIRST ** (power + 1)) / (power + 1)


SLOPE = 2 * STRESS / np.sqrt(np.pi)  # K over the root of a


@given(st.floats(0, 0.8), st.floats(0.3, 1.0), st.floats(2.1, 4))
def test_the_life_of_a_penny_by_walker_is_exact(ratio, gamma, m):
    """Paris' life (Paris & Erdogan 1963) with Walker's Delta K (1 - R)^(gamma - 1) (1970)."""
    last = grown(6, rates=(f"walker:1e-12,{m},{gamma}",), stress_ratio=ratio)
    at_zero = SLOPE * (1 - ratio) / (1 - ratio) ** (1 - gamma)
    assert last.cycles == pytest.approx(integral(-m / 2, last.size) / (1e-12 * at_zero**m), rel=1e-8)


@pytest.mark.parametrize("ratio", [-1.0, 0.0, 0.5])
def test_the_life_of_a_penny_by_forman_is_its_closed_form(ratio):
    """Forman, Kearney & Engle (1967), integrated: both terms are powers of a."""
    m, toughness, opens = 3.2, 250.0, 1 - max(ratio, 0.0)
    last = grown(20, rates=(f"forman:1e-10,{m},{toughness}",), stress_ratio=ratio)
    span = SLOPE * opens
    exact = opens * toughness * integral(-m / 2, last.size) / (1e-10 * span**m)
    exact -= integral((1 - m) / 2, last.size) / (1e-10 * span ** (m - 1))
    # da/dN is a power of a over each step of 5 %: 1.2e-4 where K comes to 0.73 K_c
    assert last.cycles == pytest.approx(exact, rel=3e-4)
    assert abs(last.cycles - exact) < last.doubt


@pytest.mark.parametrize("ratio", [-1.0, 0.0, 0.4, 0.8])
def test_nasgros_rate_is_its_formula_and_a_constant_k_gives_the_exact_life(ratio):
    """The NASGRO equation as AFGROW's manual prints it (AFRL-VA-WP-TR-1999-3016)."""
    law, largest = NASGRO, 400.0
    level, at_zero = (float(opening_level(np.array([r]), 2.0, 0.3)[0]) for r in (ratio, 0.0))
    c = law["below"] if ratio < 0 else law["c"]
    delta_k = (1 - ratio) * largest
    threshold = law["threshold"] * ((1 - level) / ((1 - at_zero) * (1 - ratio))) ** (-(1 + c * ratio))
    exact = law["C"] * ((1 - level) / (1 - ratio) * delta_k) ** law["n"]
    exact *= (1 - threshold / delta_k) ** law["p"] / (1 - largest / law["K_c"]) ** law["q"]
    assert rate(text_of(law), largest, ratio) == pytest.approx([exact], rel=1e-12)
    k = np.tile([largest, 0, 0], (5, 1))
    options = GrowthOptions(rates=(text_of(law),), stress_ratio=ratio, extension=0.5)
    first = kinks_and_extensions(FrontPoints.of(k, 3.0), options)[1]
    second = kinks_and_extensions(FrontPoints.of(k, 3.5, last=first), options)[1]
    assert second.cycles == pytest.approx(0.5 / exact, rel=1e-9)


def test_nasgro_without_its_ends_is_paris_with_newmans_closure():
    plain = text_of(NASGRO | {"p": 0, "q": 0, "threshold": 0})
    for ratio in (-1.5, 0.0, 0.6):
        opens = 1 - opening_level(np.array([ratio]), 2.0, 0.3)
        assert rate(plain, 300.0, ratio) == pytest.approx(2e-12 * (300 * opens) ** 3.2)


@pytest.mark.parametrize(
    ("law", "threshold", "toughness"),
    [("walker:1e-9,3,0.5,50", 50, np.inf), ("forman:1e-9,3,400,50", 50, 400), (text_of(NASGRO), 80, 2000)],
)
def test_laws_start_at_their_threshold_and_end_at_k_c(law, threshold, toughness):
    assert (rate(law, [0.0, threshold * (1 - 1e-9)]) == 0).all()
    assert (rate(law, threshold * (1 + 1e-9)) > 0).all()
    assert np.isfinite(rate(law, min(toughness, 1e6) * (1 - 1e-9))).all()
    assert (rate(law, 100.0, 1.0) == 0).all()  # a load that does not change
    if toughness < np.inf:
        assert np.isinf(rate(law, [toughness, 2 * toughness])).all()


def test_a_table_of_ratios_gives_back_the_law_that_it_was_made_of():
    spans = np.geomspace(50, 800, 9)
    rows = [(r, dk, 1e-10 * (dk / (1 - r) ** 0.4) ** 3) for r in (-0.5, 0.0, 0.3, 0.6) for dk in spans]
    law = "table_of_ratios:" + ",".join(f"{value!r}" for row in rows for value in map(float, row))
    dk = np.array([60.0, 150.0, 1500.0])
    for ratio in (-0.5, 0.0, 0.3, 0.6):
        exact = 1e-10 * (dk / (1 - ratio) ** 0.4) ** 3
        assert rate(law, dk / (1 - ratio), ratio) == pytest.approx(exact, rel=1e-10)
    # ln(da/dN) is linear in R between: 4.7 % off Walker's power halfway from 0.3 to 0.6
    assert rate(law, dk / 0.55, 0.45) == pytest.approx(1e-10 * (dk / 0.55**0.4) ** 3, rel=0.06)
    # beyond the table its ends apply: compression below the smallest R does not count
    assert rate(law, 100.0, -2.0) == pytest.approx(rate(law, 100.0, -0.5))
    assert (rate(law, [49 / 0.7, 51 / 0.7], 0.3) > 0).tolist() == [False, True]


@given(
    st.lists(st.tuples(st.integers(1, 1000), st.floats(0.1, 2), st.floats(-1, 0.9)), min_size=1, max_size=4)
)
def test_the_life_of_a_penny_under_blocks_is_that_of_the_mean_of_their_powers(rows):
    """Without interaction of loads: Delta K^m is the mean of the cycles' (Paris 1964)."""
    m, blocks = 3.0, tuple(f"{n},{most},{most * ratio}" for n, most, ratio in rows)
    last = grown(4, rates=(f"paris:1e-12,{m}",), blocks=blocks)
    n, most, ratio = np.array(rows).T
    mean = (n * (most * (1 - np.maximum(ratio, 0))) ** m).sum() / n.sum()
    assert last.cycles == pytest.approx(integral(-m / 2, last.size) / (1e-12 * mean * SLOPE**m), rel=1e-8)


def test_cycles_of_a_block_below_the_threshold_count_and_do_not_grow_the_crack():
    law = (f"paris:1e-12,3,{0.5 * SLOPE}",)
    alone, mixed = (grown(2, rates=law, blocks=rows) for rows in (("1,1,0",), ("1,1,0", "99,0.4,0")))
    assert mixed.cycles == pytest.approx(100 * alone.cycles, rel=1e-9)


def test_blocks_name_load_cases_whose_modes_differ():
    pull, shear = (np.tile(k, (3, 1)) for k in ([100.0, 0, 0], [0.0, 40.0, 0]))
    front = FrontPoints.of(pull, 1.0, loads={"pull": pull, "shear": shear})
    options = {"rates": ("paris:1e-9,2",), "driving": "richard", "criterion": "straight"}
    found, _ = kinks_and_extensions(
        front, GrowthOptions(blocks=("3,pull,0*pull", "1,2*shear,0*shear"), **options)
    )
    assert found.da_dn == pytest.approx(1e-9 * (3 * 100**2 + (2 * 1.155 * 40) ** 2) / 4)
    assert (found.driving == 100).all() and (found.ratio == 0).all()
    pair, _ = kinks_and_extensions(front, GrowthOptions(cycle=("pull", "shear"), **options))
    block, _ = kinks_and_extensions(front, GrowthOptions(blocks=("7,pull,shear",), **options))
    assert block.da_dn == pytest.approx(pair.da_dn) and block.ratio == pytest.approx(pair.ratio)


def test_rainflow_counts_the_published_history():
    """ASTM E1049-85, 5.4.5, fig. 7: cycles of range 4 by 1.5, 6, 8 and 9, of whole cycles 4, 4, 7 and 9."""
    rows = rainflow_blocks(np.array([-2, 1, -3, 5, -1, 3, -4, 4, -2]) + 4.0)
    found = sorted(
        (float(top) - float(low), float(number)) for number, top, low in (r.split(",") for r in rows)
    )
    assert found == [(3, 1), (4, 1), (7, 1), (9, 1)]


@given(st.lists(st.floats(-1, 1).map(lambda x: round(x, 3)), min_size=1, max_size=40), st.integers(0, 39))
def test_rainflow_does_not_depend_on_where_a_repeated_history_starts(history, start):
    history = [1.5, *history, 0.25]
    turned = history[start % len(history) :] + history[: start % len(history)]
    rows = rainflow_blocks(history)
    assert rows == rainflow_blocks(turned)
    blocks = GrowthOptions(blocks=rows).cycles()
    assert max(block.largest[0] for block in blocks) == 1.5
    assert all(block.number == int(block.number) for block in blocks)


@pytest.mark.parametrize("history", [[], [1.0], [0.0, -1.0], [1.0, float("nan")]])
def test_histories_without_a_cycle_in_tension_are_refused(history):
    with pytest.raises(CraftmeshError, match="^load history: "):
        rainflow_blocks(history)


@pytest.mark.parametrize(
    "row", ["1,1", "0,1,0", "1,-1,-2", "1,1,1", "1,1,-3", "x,1,0", "1,1,0,0", "1,nan,0"]
)
def test_rows_that_are_no_blocks_are_refused(row):
    with pytest.raises(CraftmeshError, match="^blocks: .* is no row"):
        GrowthOptions(blocks=(row,))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (
            {"blocks": ("1,1,0",), "stress_ratio": 0.1},
            "blocks is given together with stress_ratio",
        ),
        ({"block_table": "a.csv", "blocks": ("1,1,0",)}, "blocks is given together with block_table"),
        ({"block_table": "a.csv", "cycle": ("a",)}, "block_table is given together with cycle"),
        ({"rates": ("walker:1,3,0.5",), "closure": "open:0.8"}, "grow.closure is 'open:0.8', but a law"),
        ({"rates": ("nasgro:1,3,0,0,0,1,1,50,4,0.3",)}, "is not a law"),
        ({"rates": ("forman:1,3,0",)}, "is not a law"),
        ({"rates": ("table_of_ratios:0,1,1,0,2",)}, "is not a law"),
        ({"rates": ("no_such_module:law",)}, "rates 'no_such_module:law' cannot be loaded"),
    ],
)
def test_laws_and_loads_that_contradict_each_other_are_refused(options, said):
    with pytest.raises(CraftmeshError, match=said):
        laws_of(GrowthOptions(**options))


def test_a_law_of_ones_own_is_taken_by_phase(monkeypatch):
    def linear(cycle):
        assert cycle.front.k.shape == (2, 3) and (cycle.ratio == 0.5).all()
        return 1e-9 * cycle.delta_k

    functions = {"linear": linear, "low": lambda c: -c.delta_k, "words": lambda c: ["a", "b"]}
    monkeypatch.setitem(sys.modules, "own_rule", SimpleNamespace(**functions))
    k = np.tile([10.0, 0, 0], (2, 1))
    front = FrontPoints.of(k, 1.0, phase=np.array([1, 2]), grain=np.array([1, 2]))
    options = GrowthOptions(rates=("1=own_rule:linear", "2=paris:1e-9,2"), stress_ratio=0.5)
    found, count = kinks_and_extensions(front, options)
    assert found.da_dn == pytest.approx([5e-9, 25e-9])
    assert count.power == pytest.approx(1.5)  # the median of 1 and 2
    with pytest.raises(CraftmeshError, match="grow.rates: a law returned an invalid array"):
        kinks_and_extensions(front, GrowthOptions(rates=("own_rule:low",)))
    with pytest.raises(CraftmeshError, match=r"a law returned \['a', 'b'\]; expected 2 rates, 0 or above"):
        kinks_and_extensions(front, GrowthOptions(rates=("own_rule:words",)))


@pytest.mark.parametrize(("ratio", "share"), [(0.0, 0.4), (0.3, -0.5), (0.5, 1.5)])
def test_a_residual_stress_adds_to_both_ends_of_a_cycle(ratio, share):
    """Delta K is that of the load, and Walker's law sees R of the sum, in cycles and in blocks."""
    m, gamma, known = 3.0, 0.5, front_of(1.0).k
    front = FrontPoints.of((1 + share) * known, 1.0, still={"": share * known})
    exact = (ratio + share) / (1 + share)
    for load in ({"stress_ratio": ratio}, {"blocks": (f"5,1,{ratio}",)}):
        found, _ = kinks_and_extensions(front, GrowthOptions(rates=(f"walker:1e-12,{m},{gamma}",), **load))
        assert found.ratio == pytest.approx(exact) and found.driving == pytest.approx((1 + share) * SLOPE)
        at_zero = (1 + share) * SLOPE * (1 - max(exact, 0.0)) ** gamma
        assert found.da_dn == pytest.approx(1e-12 * at_zero**m)
    half, _ = kinks_and_extensions(front, GrowthOptions(coefficient=1e-12, blocks=("1,0.5,0",)))
    assert half.driving == pytest.approx(max(0.5 + share, 0) * SLOPE)


def test_a_crack_at_k_c_is_unstable():
    for options in ({"toughness": SLOPE}, {"rates": (f"forman:1e-9,3,{SLOPE}",)}):
        stays = [
            kinks_and_extensions(front_of(size), GrowthOptions(extension=0.1, **options))[0].stays
            for size in (0.99, 1.01)
        ]
        assert (stays[0] == "").all() and (stays[1] == UNSTABLE).all()
    largest = GrowthOptions(toughness=1.5 * SLOPE, blocks=("1000,1,0", "1,1.6,0"))
    assert (kinks_and_extensions(front_of(1.0), largest)[0].stays == UNSTABLE).all()


def test_a_section_at_yield_ends_the_growth():
    options = GrowthOptions(extension=0.1, yield_stress=200.0)
    for net, word in ((199.0, ""), (201.0, YIELDS)):
        assert (kinks_and_extensions(front_of(1.0, net_stress=net), options)[0].stays == word).all()


@pytest.mark.parametrize("normal", [(0, 0, 1), (0.6, 0, 0.8), (1, 1, 1)])
def test_the_section_of_a_cube_has_its_exact_area(normal):
    """Through the middle: 16, 16 / 0.8, and a regular hexagon; the mesh's planes lie in the first."""
    mesh = assemble(*structured_box((4, 4, 4), lambda c: np.ones(len(c), int)))[0]
    normal = np.array(normal) / np.linalg.norm(normal)
    exact = {0.0: 16.0, 0.6: 20.0}.get(round(normal[0], 9), 16 * 0.75 * 3**0.5)
    assert section_area(mesh, mesh.box.mean(axis=0), normal) == pytest.approx(exact, rel=1e-9)


def test_the_verbs_end_growth_at_k_c_and_at_net_section_yield(tmp_path, capsys):
    """A bar 8 x 3 x 8 with an edge crack 4 deep under 100: its ligament carries 200."""
    write_edge_crack(tmp_path, (8, 3, 8))
    write_labels(tmp_path / "labels.npz", Voxels(np.ones((8, 3, 8), int), np.ones(3), np.zeros(3)))
    frames = front_frames(read_tets(tmp_path / "volume.vtu"))
    write_front(tmp_path / "front.csv", frames.columns())
    files = {
        name: str(tmp_path / name) for name in ("volume.vtu", "u.npz", "sif.csv", "f.json", "crack.vtp")
    }
    model = ["--material", "isotropic:70000,0.3", "--quarter-points"]
    model += ["--faces", "ZMIN.z=fixed", "ZMIN.x=fixed", "ZMIN.y=fixed", "ZMAX.z=stress:100"]
    assert main(["solve", files["volume.vtu"], "-o", files["u.npz"], *model]) == 0
    step = [
        "fracture",
        files["volume.vtu"],
        files["u.npz"],
        "-o",
        files["sif.csv"],
        "--json",
        files["f.json"],
    ]
    step += ["--crack", files["crack.vtp"], *model]
    step += ["--extension", "1"]
    grow = ["grow", files["crack.vtp"], files["sif.csv"], str(tmp_path / "front.csv")]
    grow += ["--volume", str(tmp_path / "labels.npz"), "-o", str(tmp_path / "grown.vtp")]
    for flags, said in (
        (
            ["--yield-stress", "199"],
            "no point of the front extends: 4 yields (the mean stress over the",
        ),
        (["--yield-stress", "201"], ""),
        (["--toughness", "100"], "the crack is unstable: 4 unstable (the driving force reaches K_c)"),
        (["--blocks", "10,1,0", "1,0.5,0", "--coefficient", "1e-12"], ""),
    ):
        assert main([*step, *flags]) == 0
        capsys.readouterr()
        assert main([*grow, "--report", str(tmp_path / "growth.json")]) == 0
        ended = json.loads((tmp_path / "growth.json").read_text())["ended"]
        assert ended.startswith(said) if said else not ended
        if "--yield-stress" in flags:  # 1e-3: the clamped end shears the bar
            net = json.loads((tmp_path / "f.json").read_text())["growth"]["net_stress"]
            assert net == pytest.approx(200, rel=1e-3)
    columns = read_front(tmp_path / "sif.csv")
    (tmp_path / "blocks.csv").write_text("Cycles,largest,smallest\n10,1,0\n1,0.5,0\n")
    table = ["--block-table", str(tmp_path / "blocks.csv"), "--coefficient", "1e-12"]
    assert main([*step, *table]) == 0
    assert (read_front(tmp_path / "sif.csv")["da_dN"] == columns["da_dN"]).all()
    history = "time,load\n" + "".join(f"{t},{load}\n" for t, load in enumerate([1, 0] * 10 + [0.5, 0]))
    (tmp_path / "blocks.csv").write_text(history)
    assert main([*step, *table]) == 0
    assert read_front(tmp_path / "sif.csv")["da_dN"] == pytest.approx(columns["da_dN"], rel=1e-12)
    for text, said in (
        ("load\n1\nx\n", "blocks.csv, line 3: load is 'x'; expected a finite number"),
        ("load\n1\n1\n", "blocks.csv: load history: its 2 loads have no cycle"),
        ("cycles,largest\n1,1\n", "blocks.csv: its columns are cycles, largest, its rows 1; expected"),
        ("cycles,largest,smallest\n1,1,2\n", "blocks.csv: blocks: '1,1,2' is no row"),
    ):
        (tmp_path / "blocks.csv").write_text(text)
        capsys.readouterr()
        assert main([*step, *table]) == 1 and said in capsys.readouterr().err
    mean = 1e-12 * (10 * columns["driving"] ** 3 + (0.5 * columns["driving"]) ** 3) / 11
    assert columns["da_dN"] == pytest.approx(mean) and (columns["R"] == 0).all()
    (tmp_path / "stress.csv").write_text("szz\n50\n")
    residual = ["--residual-stress", str(tmp_path / "stress.csv")]
    assert main(["solve", files["volume.vtu"], "-o", files["u.npz"], *model, *residual]) == 0
    assert main([*step, *residual, "--yield-stress", "199"]) == 0
    both = read_front(tmp_path / "sif.csv")
    # residual K over the sum's is R of a load that goes to 0: a third of 50 and 100
    assert both["R"] == pytest.approx(1 / 3, rel=1e-2)
    assert (both["driving"] > 1.4 * columns["driving"]).all()
    net = json.loads((tmp_path / "f.json").read_text())["growth"]["net_stress"]
    assert net == pytest.approx(200, rel=1e-3)  # of the load alone

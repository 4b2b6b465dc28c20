"""Cases that differ in a size alone are found, and the size that converged is the coarsest good one."""

import pytest
from shown_models import asked, config, write_front, write_increment

from craftmesh.cli import main
from craftmesh.report.charts import against_size, converged
from craftmesh.report.sweeps import Sweep, sweeps


def record(l_min=1.0, **others):
    asks = {"microstructure": "synthetic", "cracks": ["edge"], "growth": "prescribed"}
    return asks | {"config": config(l_min, **others.pop("sizing", {})) | others}


def found(**records):
    return [(sweep.key, sweep.sizes, sweep.cases) for sweep in sweeps(records)]


def test_cases_of_several_sizes_are_a_sweep_from_coarse_to_fine():
    cases = {"a": record(0.5), "b": record(0.9), "c": record(0.7)}
    assert found(**cases) == [("sizing.l_min", (0.9, 0.7, 0.5), ("b", "c", "a"))]


def test_cases_that_differ_otherwise_are_none():
    assert found(a=record(0.5), b=record(0.7, solve={"tolerance": 1e-6})) == []
    assert found(a=record(0.5), b=record(0.7) | {"microstructure": "other.npz"}) == []
    assert found(a=record(0.5), b=record(0.5)) == []


def test_a_grid_of_sizes_is_a_sweep_along_each_line():
    cases = {f"{a}-{b}": record(a, sizing={"l_max": b}) for a in (0.5, 0.7) for b in (2.0, 3.0, 4.0)}
    keys = [sweep.key for sweep in sweeps(cases)]
    assert sorted(keys) == ["sizing.l_max"] * 2 + ["sizing.l_min"] * 3
    assert [len(sweep.cases) for sweep in sweeps(cases)] == [3, 3, 2, 2, 2]


def test_sizes_that_rise_together_are_one_sweep():
    cases = {str(k): record(0.5 * k, sizing={"l0": 1.0 * k, "l_max": 2.0 * k}) for k in (1, 2, 3)}
    assert found(**cases) == [("sizing.l_min", (1.5, 1.0, 0.5), ("3", "2", "1"))]
    assert found(a=record(0.5, sizing={"l_max": 3.0}), b=record(0.7, sizing={"l_max": 2.0})) == []


@pytest.mark.parametrize(
    ("values", "size"),
    [
        ([120, 104, 101, 100], 0.8),
        ([104, 120, 101, 100], 0.7),  # 0.9 is near by chance: the next finer one is not
        ([120, 110, 106, 100], None),
        ([None, 104, None, 100], 0.8),
        ([-120, -104, -101, -100], 0.8),
    ],
)
def test_the_coarsest_size_from_which_all_are_near_the_finest(values, size):
    assert converged("K_I", (0.9, 0.8, 0.7, 0.6), values, 0.05).size == size


def test_one_value_and_measures_of_the_mesh_are_not_judged():
    assert not converged("K_I", (0.9, 0.8), [None, 1.0], 0.05).judged
    assert not converged("elements", (0.9, 0.8), [10, 20], 0.05).judged


@pytest.mark.slow
def test_the_page_names_the_size(tmp_path):
    sizes = {"coarse": 0.9, "middle": 0.7, "fine": 0.6}
    settings = {name: {"sizing": config(size)["sizing"]} for name, size in sizes.items()}
    for name, k_1 in (("coarse", [1, 2, 3]), ("middle", [10, 20, 30]), ("fine", [10, 21, 30])):
        write_increment(tmp_path / name / "000", sizes[name])
        write_front(tmp_path / name / "000", k_1, ("end", "", "end"))
    page = tmp_path / "report.html"
    flags = [
        "--campaign",
        asked(tmp_path, sizes, settings=settings),
        "-o",
        str(page),
        "--quantity",
        "largest_K_I",
    ]
    assert main(["report", str(tmp_path), *flags]) == 0
    text = page.read_text()
    assert "converged at 0.7" in text and "sizing.l_min, increment 000" in text
    assert "within 5 %" in text
    assert main(["report", str(tmp_path), *flags, "--tolerance", "0.01"]) == 0
    assert "not converged" in page.read_text()


def test_each_quantity_has_a_chart_with_units_on_both_axes():
    sweep = Sweep("sizing.l_min", (0.9, 0.7), ("a", "b"))
    found = [converged(name, sweep.sizes, [1.0, 2.0], 0.05) for name in ("K_I", "J")]
    figures = against_size(sweep, found, 0.05, {"K_I": "K_I [MPa]", "J": "J [N]"}, "um")
    labels = [(figure.axes[0].get_xlabel(), figure.axes[0].get_ylabel()) for figure in figures]
    assert labels == [("sizing.l_min [um]", "K_I [MPa]"), ("sizing.l_min [um]", "J [N]")]

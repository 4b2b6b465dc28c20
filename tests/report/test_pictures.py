"""Pictures are the same text each time, show what they are given, and take the colours of their page."""

import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from craftmesh.report.charts import along_front, histograms
from craftmesh.report.pictures import as_svg, crack_path, deformed_body, value_on_plane
from craftmesh.report.shaded import view_from

TOWARDS = np.array([1.0, -0.8, 0.6])
BOX = np.array([[0.0, 0.0, 0.0], [10.0, 10.0, 10.0]])
TET = np.array([[0.0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]]), np.array([[0, 1, 2, 3]])


def path(radius):
    angle = np.linspace(0, np.pi, 20)
    front = np.column_stack([5 + radius * np.cos(angle), radius * np.sin(angle), np.full(20, 5.0)])
    body = np.ones((60, 80, 4))
    return crack_path(body, view_from(TOWARDS, BOX), {"000": [front], "001": [1.5 * front]}, "um")


def intensities(k2, flags=("",) * 20, error=0.1):
    s = np.arange(20.0)
    columns = {"front": np.ones(20, int), "s": s, "K_I": np.sin(s / 3), "K_II": k2 * np.cos(s / 3)}
    others = {"K_III": 0 * s, "kink_angle": 0 * s, "error": np.full(20, error), "flags": np.array(flags)}
    return {"000": columns | others}


def stress(value):
    return value_on_plane(*TET, np.array([value]), np.array([1.0, 1.0, 1.0]), 2, "stress [MPa]", "um")


PICTURES = [
    (lambda: path(2.0), lambda: path(3.0)),
    (lambda: along_front(intensities(1.0))[1], lambda: along_front(intensities(2.0))[1]),
    (
        lambda: deformed_body(TET[0], TET[1][:, :3], TET[0] * [0.1, 0, 0], TOWARDS),
        lambda: deformed_body(TET[0], TET[1][:, :3], TET[0] * [0, 0.1, 0], TOWARDS),
    ),
    (lambda: stress(1.0), lambda: stress(2.0)),
]


@pytest.mark.parametrize(("picture", "other"), PICTURES, ids=["path", "front", "body", "stress"])
def test_a_picture_is_the_same_for_the_same_and_another_for_another(picture, other):
    first = as_svg(picture())
    assert first == as_svg(picture()) != as_svg(other())
    root = ET.fromstring(first)
    assert root.tag.endswith("svg") and len(list(root.iter("{http://www.w3.org/2000/svg}text"))) > 1


def test_a_body_without_displacement_is_drawn_as_it_is():
    svg = as_svg(deformed_body(TET[0], TET[1][:, :3], 0 * TET[0], TOWARDS))
    assert "drawn 1 times as large" in svg


@pytest.mark.parametrize("picture", [pair[0] for pair in PICTURES], ids=["path", "front", "body", "stress"])
def test_ground_and_ink_are_the_pages(picture):
    svg = as_svg(picture())
    assert "currentColor" in svg and not re.search(r"#(000000|ffffff)|<style|<metadata|pt\"", svg)


def test_a_picture_of_a_body_has_axes_a_scale_and_units():
    words = [text.get_text() for text in path(2.0).axes[0].texts]
    assert {"x", "y", "z", "2 um"} <= set(words)
    assert path(2.0).axes[1].get_ylabel() == "crack front of increment"
    assert stress(1.0).axes[0].get_xlabel() == "x [um]"


def test_lines_join_reliable_nodes_within_the_band_of_the_error_and_others_are_open_marks():
    flags = ["end", *[""] * 8, "error", *[""] * 9, "end"]
    axes = along_front(intensities(1.0, flags), "MPa sqrt(um)")[0].axes[0]
    assert axes.get_ylabel() == "K_I [MPa sqrt(um)]"
    line, marks = axes.lines
    # nodes less than two edges from an end are doubted as well
    assert np.flatnonzero(np.isnan(line.get_ydata())).tolist() == [0, 1, 9, 18, 19]
    assert len(marks.get_xdata()) == 5 and marks.get_fillstyle() == "none"
    (band,) = axes.collections
    assert max(np.ptp(path.vertices[:, 1]) for path in band.get_paths()) >= 0.2  # the error on both sides
    low, high = axes.get_ylim()
    kept = line.get_ydata()[np.isfinite(line.get_ydata())]
    assert low < kept.min() - 0.1 and high > kept.max() + 0.1


def test_k_that_grows_many_times_over_leaves_the_curves_before_it_apart():
    """Curves of K, 2 K and 1000 K lie apart; the scale of K, 2 K and 3 K stays linear."""
    one = intensities(0.0)["000"] | {"K_I": np.full(20, 5.0)}
    for last, scale in ((3, "linear"), (1000, "log")):
        rows = {f"{n:03d}": one | {"K_I": n * one["K_I"]} for n in (1, 2, last)}
        figure, *_, angle = along_front(rows)
        axes = figure.axes[0]
        assert axes.get_yscale() == scale and angle.axes[0].get_yscale() == "linear"
        places = axes.transData.transform([(0.5, 5.0 * n) for n in (1, 2, last)])
        height = axes.transAxes.inverted().transform(places)[:, 1]
        assert (np.diff(height) > 0.05).all() and 0 < height[0] and height[-1] < 1


def test_each_histogram_is_a_panel_of_its_own():
    one = {"edges": [1, 2, None], "counts": [3, 1]}
    quality = {"histograms": dict.fromkeys(("aspect_ratio", "dihedral_min", "dihedral_max"), one)}
    assert [len(figure.axes) for figure in histograms({"000": quality, "001": quality})] == [1, 1, 1]

"""Elements, time and memory that a plan tells are within a factor of 1.5 of what was measured."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import yaml

from craftmesh.campaign.campaign import read_campaign
from craftmesh.campaign.job_resources import (
    RULES,
    TETS_PER_CUBE,
    Sizes,
    effort,
    expected_elements,
    expected_facets,
)
from craftmesh.commands.plan import sizes_of
from craftmesh.types import Voxels

ROOT = Path(__file__).resolve().parents[2]
FACTOR = 1.5


@dataclass(frozen=True)
class Uniform:
    length: float

    def at(self, points):
        return np.full(len(points), self.length)


def test_uniform_lengths_fill_the_grains_alone():
    labels = np.ones((20, 10, 30), int)
    labels[:, :5] = 0
    voxels = Voxels(labels, (0.5, 2.0, 1.0), (0, 0, 0))
    # half of 20 x 10 x 30 voxels of volume 1; a slice of samples at the boundary counts whole: 1 in 60
    assert expected_elements(voxels, Uniform(0.25)) == pytest.approx(
        TETS_PER_CUBE * 3000 / 0.25**3, rel=0.02
    )


def test_lengths_that_vary_are_summed_where_they_are():
    @dataclass(frozen=True)
    class Linear:
        def at(self, points):
            return 1 + points[:, 0] / 10

    voxels = Voxels(np.ones((10, 10, 10), int), (1, 1, 1), (0, 0, 0))
    exact = 100 * 5 * (1 - 1 / 4)  # the integral of (1 + x / 10)^-3 over 0 to 10, times the section
    assert expected_elements(voxels, Linear()) == pytest.approx(TETS_PER_CUBE * exact, rel=1e-3)


def test_facets_follow_the_boundaries():
    labels = np.ones((10, 10, 10), int)
    one = expected_facets(Voxels(labels, (1, 1, 1), (0, 0, 0)))
    labels[5:] = 2
    assert expected_facets(Voxels(labels, (1, 1, 1), (0, 0, 0))) == pytest.approx(one * 7 / 6)


# last increments as the README has them; al6xn's first, and both ends of cracks that grow
MEASURED = [
    ("al6xn/config.yaml", {"000": 279_379}),
    ("al1050/config.yaml", {"002": 646_000}),
    ("copper/config.yaml", {"002": 1_407_000}),
    ("al1050/growth.yaml", {"000": 68_535, "004": 95_915}),
    ("copper/growth.yaml", {"000": 136_121, "004": 155_105}),
    ("measured_crack/config.yaml", {"000": 83_935}),
]


@pytest.mark.parametrize("example, elements", MEASURED, ids=[name for name, _ in MEASURED])
def test_elements_of_the_examples(example, elements, shared_data, monkeypatch):
    monkeypatch.chdir(ROOT)
    config = yaml.safe_load((ROOT / "examples" / example).read_text()) | {"data": str(shared_data)}
    campaign = read_campaign(config | {"results": "no-results-there"})
    (sizes,) = sizes_of(campaign, campaign.cases.values()).values()
    for inc, count in elements.items():
        assert count / FACTOR < sizes[inc].elements < count * FACTOR


def test_elements_around_given_voids(monkeypatch):
    """The foam of examples/paper_1 as it was meshed, its struts here in voxels five times as large."""
    monkeypatch.chdir(ROOT)
    config = yaml.safe_load((ROOT / "examples/paper_1/config.yaml").read_text())
    coarse = config["generate"] | {"shape": [48] * 3, "spacing": [10 / 48] * 3}
    campaign = read_campaign(config | {"generate": coarse, "results": "no-results-there"})
    sizes = sizes_of(campaign, campaign.cases.values())
    for case, count in {"gradated": 1_235_149, "uniform": 7_945_882}.items():
        assert count / FACTOR < sizes[case]["000"].elements < count * FACTOR


# CPU seconds and MB of single jobs with compiled kernels: voxels, facets and elements of the increment
COPPER, AL1050 = Sizes(32_768, 103_175, 155_105), Sizes(718_528, 332_611, 95_915)
COPPER_FINE, AL6XN = Sizes(32_768, 103_175, 1_488_678), Sizes(143_888, 153_938, 354_665)
PAPER_2, PAPER_2_UNIFORM = Sizes(1e6, 801_431, 1_646_709), Sizes(1e6, 801_431, 8_313_951)
PAPER_3_UNIFORM = Sizes(223_600, 131_008, 2_440_000)
JOBS = [
    ("remesh", AL6XN, 3.3, 219),
    ("remesh", AL1050, 6.4, 273),
    ("remesh", Sizes(8e6, 4_041_256, 0), 46.9, 1_083),
    ("stitch", COPPER, 5.4, 295),
    ("stitch", AL1050, 6.5, 395),
    ("gradate", COPPER, 5.0, 323),
    ("gradate", AL1050, 7.9, 387),
    ("gradate", COPPER_FINE, 9.1, 424),
    ("tetrahedralize", COPPER, 7.7, 430),
    ("tetrahedralize", AL1050, 5.8, 430),
    ("assemble", COPPER, 4.5, 383),
    ("assemble", AL1050, 2.4, 314),
    ("inp", COPPER, 2.1, 324),
    ("inp", AL1050, 2.1, 292),
    ("depict", AL6XN, 3.8, 430),
    ("depict", COPPER_FINE, 6.9, 720),
    ("solve", COPPER, 15.3, 709),
    ("fracture", COPPER, 9.8, 451),
    ("fracture", AL1050, 6.7, 334),
    ("solve", Sizes(0, 0, 513_205), 39.9, 1_623),
    ("crack", PAPER_2, 2.3, 237),
    ("size", PAPER_2, 2.0, 258),
    ("gradate", PAPER_2, 22.6, 656),
    ("gradate", PAPER_2_UNIFORM, 23.1, 668),
    ("tetrahedralize", PAPER_2, 23.4, 472),
    ("tetrahedralize", PAPER_2_UNIFORM, 82.0, 605),
    ("assemble", PAPER_2, 39.3, 891),
    ("assemble", PAPER_2_UNIFORM, 221.0, 3_906),
    ("inp", PAPER_2, 7.7, 1_062),
    ("solve", PAPER_3_UNIFORM, 282.0, 6_607),
    ("fracture", PAPER_3_UNIFORM, 82.4, 1_403),
]


@pytest.mark.parametrize("rule, sizes, seconds, megabytes", JOBS)
def test_time_and_memory_of_a_job(rule, sizes, seconds, megabytes):
    told = effort(rule, sizes)
    assert seconds / FACTOR < told.seconds < seconds * FACTOR
    assert megabytes / FACTOR < told.megabytes < megabytes * FACTOR


@pytest.mark.parametrize("rule", RULES)
def test_stages_that_share_a_start_take_less_but_none_takes_less_than_nothing(rule):
    alone, warm = (effort(rule, Sizes(0, 0, 0), is_warm=is_warm).seconds for is_warm in (False, True))
    assert 0 <= warm < alone


def test_more_chunks_share_the_tetrahedra():
    two, four = (effort("tetrahedralize", AL1050, chunks) for chunks in (2, 4))
    least = effort("tetrahedralize", Sizes(0, 0, 0)).seconds
    assert four.seconds - least == pytest.approx((two.seconds - least) / 2)

"""What jobs ask of a cluster: by the sizes of files, and never more than a node has."""

import os
from pathlib import Path

import pytest
from few_facets import double_cone
from warped_cracks import disc_crack

from craftmesh.campaign.job_resources import (
    UNKNOWN,
    VARIABLE,
    WORKERS,
    Node,
    Sizes,
    cluster_node,
    expected_facets,
    memory_mb,
    minutes,
    sizes_of,
)
from craftmesh.io.npz import write_labels
from craftmesh.io.vtk import write_surface, write_tets
from craftmesh.voxels.generate import GenerateOptions, generate

NOTHING = {"cpus": None, "mem_mb": None}
AT_WILL = Node(None, None)
SMALL, LARGE = Sizes(1e5, 1e5, 1e6), Sizes(1e6, 1e6, 1e7)


@pytest.fixture
def sinfo(tmp_path, monkeypatch):
    """Return a function that puts a `sinfo` on the path which says so much."""

    def make(text: str):
        command = tmp_path / "sinfo"
        command.write_text(f"#!/bin/sh\ncat <<END\n{text}\nEND\n")
        command.chmod(0o755)

    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.setenv(VARIABLE, "")  # so that it is restored
    monkeypatch.delenv(VARIABLE)
    return make


def test_the_smallest_node_of_the_default_partition_counts(sinfo):
    sinfo("work* 32 128000\nwork* 16 64000+\nold 2 4000")
    assert cluster_node(NOTHING) == Node(16, 64000)


def test_without_a_default_partition_all_nodes_count(sinfo):
    sinfo("work 32 128000\nold 2 4000")
    assert cluster_node(NOTHING) == Node(2, 4000)


def test_jobs_inherit_the_node_and_do_not_ask_again(sinfo):
    sinfo("work* 16 64000")
    assert cluster_node(NOTHING) == Node(16, 64000)
    sinfo("work* 1 100")
    assert cluster_node(NOTHING) == Node(16, 64000)


def test_keys_take_the_place_of_what_sinfo_says(sinfo):
    sinfo("work* 16 64000")
    assert cluster_node({"cpus": 2, "mem_mb": None}) == Node(2, 64000)
    assert cluster_node({"cpus": 2, "mem_mb": 300}) == Node(2, 300)


def test_where_nothing_is_known_a_job_takes_one_processor(sinfo):
    sinfo("")
    assert cluster_node(NOTHING) == AT_WILL and AT_WILL.workers == 1
    assert Node(2, None).workers == 2 and Node(64, None).workers == WORKERS


@pytest.mark.parametrize("stage", ["import_microstructure", "remesh", "gradate", "tetrahedralize", "solve"])
def test_needs_grow_with_size_and_attempt_up_to_the_node(stage):
    first, bigger = (memory_mb(stage, sizes, 1, AT_WILL) for sizes in (SMALL, LARGE))
    assert bigger > first > 800 and memory_mb(stage, SMALL, 2, AT_WILL) == 2 * first
    assert memory_mb(stage, LARGE, 3, Node(4, 800)) == 800
    assert minutes(stage, SMALL, 2) >= 2 * minutes(stage, SMALL, 1) > 0


def test_jobs_at_once_on_a_node_ask_for_no_more_than_it_has():
    first, second = (memory_mb(stage, LARGE, 3, Node(4, 8001)) for stage in ("inp", "check"))
    assert first == second == 4000


def test_each_worker_process_has_its_memory():
    one, four = (memory_mb("tetrahedralize", SMALL, 1, node) for node in (AT_WILL, Node(4, None)))
    assert four > one


def test_sizes_are_told_by_the_heads_of_files(tmp_path):
    volume = generate(GenerateOptions(shape=(6, 5, 4), grains=2, voids=0))
    write_labels(tmp_path / "labels.npz", volume)
    found = sizes_of(tmp_path / "labels.npz")
    assert found.voxels == 120 and found.facets == expected_facets(volume)
    surface = double_cone(5)
    write_surface(tmp_path / "gradated.vtp", surface)
    assert sizes_of(tmp_path / "gradated.vtp").facets == len(surface.facets)
    write_tets(tmp_path / "volume.vtu", disc_crack(2, 6, 2))
    assert sizes_of(tmp_path / "volume.vtu").elements == len(disc_crack(2, 6, 2).tets)
    for name in ("other.npz", "other.vtp", "other.vtu"):
        unknown = UNKNOWN[Path(name).suffix]
        assert sizes_of(tmp_path / name) == unknown
        (tmp_path / name).write_text("no such thing")
        assert sizes_of(tmp_path / name) == unknown

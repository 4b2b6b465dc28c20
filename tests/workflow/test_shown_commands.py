"""Every command that the documentation shows is run, by these tests or by others, or it is said why not."""

import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
from how_commands_are_run import (
    BY_OTHER_TESTS,
    IN_THE_GUIDE,
    IN_THE_TREE,
    IN_YOUR_OWN_DATA,
    NOT_IN_THE_GUIDE,
    NOT_RUN,
    SMALLEST,
)
from shown_commands import HERE, PAGES, ROOT, blocks_of, commands_of, run

from craftmesh.commands.verbs import VERBS
from craftmesh.io.vtk import read_surface
from craftmesh.voxels.generate import GenerateOptions, generate

GUIDE = (ROOT / "docs" / "guide.md").read_text()
README = (ROOT / "README.md").read_text()
TUTORIAL = (ROOT / "docs" / "tutorial.md").read_text()
YOUR_OWN_DATA = README.partition("## Your own data")[2].partition("## From any folder")[0]
# of craftmesher: one grain surface per file, and its lengths
CONFIG_XML = """<?xml version="1.0"?>
<crackMesher>
  <stls>grains</stls><OriginalEdgeLength>1.0</OriginalEdgeLength><R0>8</R0><Rt>20</Rt>
  <refinement><VolumeTargetEdgeLength>0.5</VolumeTargetEdgeLength></refinement>
</crackMesher>
"""


def lines_of(text: str) -> list[str]:
    """Return the commands in the fences of a text."""
    return [shown.line for block in blocks_of(text) for shown in block]


def run_all(folder: Path, lines: dict[str, str], programs: Path = HERE):
    """Run each line, or what stands for it."""
    for shown, instead in lines.items():
        run(folder, instead or shown, programs)


def write_scan(path: Path, shape: tuple[int, int, int], grains: int):
    """Write a generated volume as DREAM.3D of version 6 does, with an orientation of each grain."""
    plain = {"voids": 0, "embedded_grains": 0, "embedded_pairs": 0}
    labels = generate(GenerateOptions(shape=shape, grains=grains, **plain)).labels
    angles = np.random.default_rng(1).uniform(0, 1, (labels.max() + 1, 3))
    with h5py.File(path, "w") as file:
        image = file.create_group("DataContainers/Image")
        image["_SIMPL_GEOMETRY/DIMENSIONS"] = np.array(shape, np.int64)
        image["_SIMPL_GEOMETRY/SPACING"] = np.ones(3, np.float32)
        image["_SIMPL_GEOMETRY/ORIGIN"] = np.zeros(3, np.float32)
        image["CellData/FeatureIds"] = labels.transpose(2, 1, 0)[..., None].astype(np.int32)
        image["CellFeatureData/AvgEulerAngles"] = angles.astype(np.float32)
        image["CellFeatureData/Phases"] = np.ones((len(angles), 1), np.int32)


def write_grains(folder: Path, surface):
    """Write the closed surface of each grain as an OFF file, outward."""
    folder.mkdir()
    for grain in np.unique(surface.sides[surface.sides > 0]):
        behind, ahead = (surface.sides == grain).T
        facets = np.concatenate([surface.facets[behind], surface.facets[ahead, ::-1]])
        used, corners = np.unique(facets, return_inverse=True)
        rows = [" ".join(map(repr, point)) for point in surface.points[used].tolist()]
        rows += [f"3 {a} {b} {c}" for a, b, c in corners.reshape(-1, 3).tolist()]
        text = "\n".join(["OFF", f"{len(used)} {len(facets)} 0", *rows])
        (folder / f"grain_{grain}.off").write_text(text + "\n")


def is_name(line: str) -> bool:
    """Return whether it is a verb that is spoken of, and needs more to be run."""
    words = line.split()
    return (
        len(words) == 2
        and words[0] == "craftmesh"
        and words[1] in VERBS
        and words[1] not in ("compile", "snakefile")
    )


def ways_to_run(line: str) -> list[str]:
    """Return the places that run a command, or say why it is not run."""
    here = {
        "the guide": {*lines_of(GUIDE), *IN_THE_GUIDE} - set(NOT_IN_THE_GUIDE),
        "your own data": {*lines_of(YOUR_OWN_DATA), *IN_YOUR_OWN_DATA},
        "the tree": set(IN_THE_TREE),
        "the tutorial": set(lines_of(TUTORIAL)),
    }
    found = [name for name, lines in here.items() if line in lines]
    return found + [start for start in (*BY_OTHER_TESTS, *NOT_RUN) if line.startswith(start)]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_each_command_is_run_somewhere(page):
    shown = [shown.line for shown in commands_of(page.read_text())]
    assert [line for line in shown if not is_name(line) and not ways_to_run(line)] == []


def test_the_tables_name_what_is_shown_and_tests_that_exist():
    shown = {shown.line for page in PAGES for shown in commands_of(page.read_text())}
    listed = {*IN_THE_GUIDE, *NOT_IN_THE_GUIDE, *IN_YOUR_OWN_DATA, *IN_THE_TREE}
    assert listed - shown == set()
    starts = [*BY_OTHER_TESTS, *NOT_RUN]
    assert [start for start in starts if not any(line.startswith(start) for line in shown)] == []
    for name in set(BY_OTHER_TESTS.values()):
        file, _, test = name.partition("::")
        assert f"\ndef {test}(" in (ROOT / "tests" / file).read_text(), name
    assert ways_to_run("craftmesh gradate a.vtp -o b.vtp") == []


@pytest.mark.slow
def test_the_guide_by_hand(tmp_path):
    write_scan(tmp_path / "scan.dream3d", (48, 16, 44), 6)  # of which the guide's crack is a part
    (tmp_path / "config.xml").write_text(CONFIG_XML)
    for line in lines_of(GUIDE):
        if line not in NOT_IN_THE_GUIDE:
            run(tmp_path, line)
        if line.startswith("craftmesh remesh"):
            write_grains(tmp_path / "folder_of_grains", read_surface(tmp_path / "remeshed.vtp"))
    run_all(tmp_path, IN_THE_GUIDE)
    assert "*NSET, NSET=CRACK_FRONT" in (tmp_path / "model.inp").read_text()
    assert len(list((tmp_path / "pictures").iterdir())) > 3


@pytest.mark.slow
def test_your_own_data_of_the_readme(tmp_path):
    write_scan(tmp_path / "scan.dream3d", (22, 20, 18), 6)
    for line in lines_of(YOUR_OWN_DATA):
        run(tmp_path, line)
    assert (tmp_path / "deck.png").stat().st_size > 10_000
    run_all(tmp_path, IN_YOUR_OWN_DATA)
    assert (tmp_path / "results/scan/000/sif.csv").is_file()


@pytest.mark.slow
def test_commands_in_a_checkout_by_stages_that_end_at_once(tmp_path, idle_python, shared_data):
    tree = tmp_path / "tree"
    for name in ("config", "examples", "workflow", "profiles", ".test"):
        shutil.copytree(ROOT / name, tree / name, ignore=shutil.ignore_patterns("results", ".snakemake"))
    shutil.copy(ROOT / "Snakefile", tree)
    (tmp_path / "shared").symlink_to(shared_data.parent)
    programs = tmp_path / "programs"
    programs.mkdir()
    (programs / "snakemake").write_text(f'#!/bin/sh\nexec {idle_python} -m snakemake "$@"\n')
    (programs / "snakemake").chmod(0o755)
    run_all(tree, IN_THE_TREE, programs)
    for case, increments in (("demo", 3), ("al1050_grown", 5), ("copper_grown", 5)):
        decks = list((tree / "results" / case).glob("*/model.inp"))
        assert len(decks) == increments, case


@pytest.mark.slow
@pytest.mark.parametrize("command", SMALLEST, ids=lambda command: command.replace("/", "_"))
def test_benchmarks_run_on_their_smallest_case(tmp_path, command):
    script, *flags = command.split()
    run(tmp_path, " ".join(["python", str(ROOT / "benchmarks" / script), *flags]))

"""craftmesher's config.xml becomes a configuration, and what it cannot carry over is said."""

import pytest
import yaml

from craftmesh import cli
from craftmesh.campaign.config_schema import config_schema
from craftmesh.campaign.configuration import completed

CONFIG = """<?xml version="1.0" encoding="utf-8"?>
<crackMesher>
  <stls>../STLs/</stls>
  <binary>1</binary>
  <writeBinarySave>out</writeBinarySave>
  <OriginalEdgeLength>1.0</OriginalEdgeLength>
  <TetGenQualityMeasure>1.3/12</TetGenQualityMeasure>
  <BackgroundSMeshQuality>1.5</BackgroundSMeshQuality>
  <gradationScheme>1</gradationScheme>
  <defectType>0</defectType>
  <detectIslands>1</detectIslands>
  <R0>8</R0>
  <Rt>20</Rt>
  <a>2.5</a>
  <advancingCrackFile>AdvCrack.csv</advancingCrackFile>
  <!-- near -->
  <refinement>
    <refinement_passes>2</refinement_passes>
    <VolumeTargetEdgeLength>0.5</VolumeTargetEdgeLength>
  </refinement>
  <coarsening>
    <coarsening_passes>5</coarsening_passes>
    <SurfaceTargetEdgeLength>3</SurfaceTargetEdgeLength>
    <VolumeTargetEdgeLength>4</VolumeTargetEdgeLength>
    <EdgeSmoothing>3</EdgeSmoothing>
    <RemoveHourglass>1</RemoveHourglass>
    <Condense3>0</Condense3>
  </coarsening>
  <novelty>7</novelty>
</crackMesher>
"""


@pytest.fixture
def imported(tmp_path, capsys):
    """Return a function that imports a config.xml: exit status, configuration, what was said."""

    def run(text: str):
        (tmp_path / "config.xml").write_text(text)
        output = tmp_path / "config.yaml"
        status = cli.main(["import-config", str(tmp_path / "config.xml"), "-o", str(output)])
        said = capsys.readouterr()
        return status, yaml.safe_load(output.read_text()) if output.exists() else None, said

    return run


def test_all_that_has_a_counterpart_is_carried_over(imported, tmp_path):
    status, config, _ = imported(CONFIG)
    assert status == 0
    assert config["sizing"] == {
        "l_min": 0.5,
        "l0": 1.0,
        "l_max": 3.0,
        "r0": 8.0,
        "r1": 20.0,
        "exponent": 2.5,
        "points": (tmp_path / "AdvCrack.csv").as_posix(),
    }
    assert config["gradate"] == {
        "release_tied_nodes": True,
        "remove_unnecessary_nodes": False,
        "junction_smoothing": 3,
    }
    assert config["tetrahedralize"] == {"radius_edge_ratio": 1.3, "min_dihedral": 12.0}
    assert completed(config, config_schema())["gradate"]["passes"] > 0


def test_each_key_is_carried_over_or_named(imported):
    _, _, said = imported(CONFIG)
    begun = {line.split(":")[0] for line in said.out.splitlines()}
    assert begun == {
        "stls",
        "binary",
        "writeBinarySave",
        "BackgroundSMeshQuality",
        "gradationScheme",
        "defectType",
        "refinement/refinement_passes",
        "coarsening/coarsening_passes",
        "coarsening/VolumeTargetEdgeLength",
        "Rt",
        "advancingCrackFile",
        "novelty",
        "cases",
    }


def test_what_is_left_out_has_craftmeshers_defaults_and_a_note_for_l0(imported):
    status, config, said = imported("<crackMesher><R0>8</R0><Rt>4</Rt></crackMesher>")
    assert status == 0 and "sizing.l0 is the voxel's edge" in said.out
    assert config["sizing"] == {"r0": 8.0, "r1": 12.0, "exponent": 3.0}
    assert config["gradate"]["junction_smoothing"] == 2


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("<R0>8</R0>", "<R0>wide</R0>", "R0 is 'wide'; expected a number"),
        ("<R0>8</R0>", "<R0>-8</R0>", "R0 is '-8'; expected a number >= 0"),
        ("<R0>8</R0>", "<R0>8</R0><R0>9</R0>", "duplicate key R0"),
        ("<R0>8</R0>", "<R0>8</RO>", "not XML"),
        ("Length>3<", "Length>0.1<", "l_min is 0.5"),
    ],
)
def test_mistakes_are_one_line_that_names_file_and_key(imported, old, new, line):
    status, config, said = imported(CONFIG.replace(old, new))
    assert status == 1 and config is None
    assert "config.xml: " in said.err and line in said.err and said.err.count("\n") == 1


def test_other_words_for_tetgen_are_said(imported):
    _, config, said = imported(CONFIG.replace("1.3/12", "pq1.4AYY"))
    assert "tetrahedralize" not in config and "TetGenQualityMeasure: 'pq1.4AYY'" in said.out


def test_order_of_keys_makes_no_difference():
    sections = {"sizing": {"l_min": 0.5, "l0": 1.0}, "cases": "cases.tsv", "gradate": {"passes": 3}}
    turned = {"gradate": {"passes": 3}, "cases": "cases.tsv", "sizing": {"l0": 1.0, "l_min": 0.5}}
    first, second = (completed(config, config_schema()) for config in (sections, turned))
    assert list(first) == list(second) and list(first["sizing"].items()) == list(second["sizing"].items())

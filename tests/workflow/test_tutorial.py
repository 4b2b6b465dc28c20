"""The tutorial's commands, run one after another as they stand."""

import re

import pytest
from shown_commands import ROOT, run

TEXT = (ROOT / "docs" / "tutorial.md").read_text()
BLOCKS = re.findall(r"```\n(.*?)```", TEXT, flags=re.S)
RUN = "craftmesh run scan.yaml"


def test_the_blocks_are_commands_and_one_sheet():
    sheets = [block for block in BLOCKS if block.startswith("case\t")]
    lines = [line for block in BLOCKS if block not in sheets for line in block.splitlines()]
    assert len(sheets) == 1 and RUN in lines
    assert all(line.startswith("craftmesh ") for line in lines)


@pytest.mark.slow
def test_from_the_file_to_the_report(tmp_path):
    for block in BLOCKS:
        if block.startswith("case\t"):
            (tmp_path / "scan.tsv").write_text(block)
            run(tmp_path, "craftmesh plan scan.yaml")
            run(tmp_path, RUN)
        else:
            for line in block.splitlines():
                run(tmp_path, line)
    assert len(list(tmp_path.glob("results/scan/*/model.inp"))) == 3
    assert len(list(tmp_path.glob("*.png"))) == 6
    assert (tmp_path / "results/report.html").stat().st_size > 100_000

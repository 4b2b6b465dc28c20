"""The script for Abaqus' own Python, run with modules in the place of Abaqus'."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from craftmesh.io.model_tables import read_displacement_table
from craftmesh.processes import job

SCRIPT = Path(job.__file__).with_name("abaqus_displacements.py")
# A database of two steps; values of a precision raise an error where the other one is asked for.
FAKE = """
class Value:
    def __init__(self, node, moved, precision):
        self.nodeLabel, self.precision = node, precision
        setattr(self, "dataDouble" if precision == "DOUBLE" else "data", moved)

class Some:
    def __init__(self, **given):
        self.__dict__.update(given)

def openOdb(path, readOnly):
    assert path == "model.odb" and readOnly
    def step(scale):
        values = [Value(2, (0.1 * scale, -2e-7, 3.0), PRECISION), Value(1, (0.0, 1.0, scale), PRECISION)]
        frames = [Some(fieldOutputs={"U": Some(values=[])}), Some(fieldOutputs={"U": Some(values=values)})]
        return Some(frames=frames)
    return Some(steps={"Step-1": step(1.0), "Step-2": step(3.0)}, close=lambda: None)
"""


@pytest.mark.parametrize("precision", ["DOUBLE", "SINGLE"])
def test_the_last_frame_of_the_last_step_is_written(tmp_path, precision):
    (tmp_path / "odbAccess.py").write_text(FAKE.replace("PRECISION", repr(precision)))
    (tmp_path / "abaqusConstants.py").write_text("DOUBLE_PRECISION = 'DOUBLE'\n")
    command = [sys.executable, str(SCRIPT), "model.odb", "field.csv"]
    environment = os.environ | {"PYTHONPATH": str(tmp_path)}
    subprocess.run(command, cwd=tmp_path, env=environment, check=True)
    numbers, values = read_displacement_table(tmp_path / "field.csv")
    assert numbers.tolist() == [2, 1]
    assert np.array_equal(values, [[0.1 * 3.0, -2e-7, 3.0], [0.0, 1.0, 3.0]])

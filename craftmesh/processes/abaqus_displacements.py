"""Write the displacements of the last frame of an Abaqus database as csv: node,ux,uy,uz.

It runs in Abaqus' own Python, 2 or 3: abaqus python abaqus_displacements.py model.odb field.csv
"""

import sys

from abaqusConstants import DOUBLE_PRECISION
from odbAccess import openOdb

source, target = sys.argv[-2:]
database = openOdb(source, readOnly=True)
last_step = database.steps[list(database.steps.keys())[-1]]
field = last_step.frames[-1].fieldOutputs["U"]
with open(target, "w") as stream:
    stream.write("node,ux,uy,uz\n")
    for value in field.values:
        moved = value.dataDouble if value.precision == DOUBLE_PRECISION else value.data
        row = [str(value.nodeLabel)] + [repr(float(component)) for component in moved]
        stream.write(",".join(row) + "\n")
database.close()

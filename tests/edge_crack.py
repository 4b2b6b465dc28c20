"""A box with an edge crack as files of a stage's input."""

import numpy as np
from structured_box import plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.series import prescribed_crack
from craftmesh.io.vtk import write_crack, write_tets


def write_edge_crack(folder, shape):
    """Write volume.vtu, a box of cells cut from x = 0 to its middle at half the height, and crack.vtp."""
    depth, width, height = shape[0] // 2, shape[1], shape[2] // 2
    is_cut = plane_crack(2, height, lambda centre: centre[:, 0] < depth)
    box = structured_box(shape, lambda centre: np.ones(len(centre), int), is_cut)
    write_tets(folder / "volume.vtu", assemble(*box)[0])
    edge = CrackOptions(shape="through_edge", centre=(0.0, width / 2, float(height)), radius=float(depth))
    write_crack(folder / "crack.vtp", prescribed_crack(np.array([[0, 0, 0], shape], float), edge))

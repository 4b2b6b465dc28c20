"""Labels become a surface.

Each voxel has a label: k > 0 for grain k, 0 for outside, -k for void k. `remesh` returns one surface in
which neighbouring grains share their facets. `check` returns a sentence for each fault of an object.
"""

import numpy as np

import craftmesh as cm

x, _, z = np.indices((14, 14, 14)) + 0.5
labels = np.where(z < 8, 1, np.where(x < 6, 2, 3))
voxels = cm.Voxels(labels, spacing=np.ones(3), origin=np.zeros(3))
surface, report = cm.remesh(voxels)
print(voxels)
print(surface)
print("faults:", cm.check(surface))
cm.write_labels("labels.npz", voxels)
cm.write_surface("remeshed.vtp", surface)

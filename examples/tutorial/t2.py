"""A measured file is cleaned.

Measured volumes have unindexed voxels and specks. `read_voxels` reads the formats of microscopes and their
programs, `clean` repairs the labels, and its report has a sentence for each kind of change.
"""

import numpy as np

import craftmesh as cm

true = cm.read_labels("labels.npz").labels
measured = true.copy()
random = np.random.default_rng(1)
for label in (0, 1, 2):  # 0: unindexed
    measured[tuple(random.integers(0, 14, (3, 20)))] = label
np.save("measured.npy", measured)

options = cm.ReadOptions(axes="xyz", spacing=(1, 1, 1), background="unindexed")
found = cm.read_voxels("measured.npy", options)
voxels, report = cm.clean(found, cm.CleanOptions(fill_unindexed=True, min_island_voxels=8))
for sentence in report["changes"]:
    print(sentence)
print("voxels with another grain than without noise:", np.count_nonzero(voxels.labels != true))

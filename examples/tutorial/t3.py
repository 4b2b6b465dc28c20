"""A crack is prescribed and prepared.

A crack is a surface with one or several fronts, and may extend beyond the body. `prescribed_crack`
makes simple shapes. `prepare_crack` moves or rejects parts that no mesh could follow, such as a front
that grazes a face.
"""

import craftmesh as cm

voxels = cm.read_labels("labels.npz")
penny = cm.CrackOptions(shape="penny", centre=(7, 7, 7), normal=(0, 0.3, 1), radius=3)
crack = cm.prepare_crack([cm.prescribed_crack(voxels.box, penny)], voxels.box, l_min=0.7)
print(crack)
print("points of its front:", len(crack.fronts[0]))
cm.write_crack("crack.vtp", crack)

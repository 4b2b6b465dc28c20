"""Two cracks in one model.

`prepare_crack` accepts several cracks and joins those that touch. Each connected crack has sets of its
own, numbered from the lowest up.
"""

import craftmesh as cm

voxels, plain = cm.read_labels("labels.npz"), cm.read_surface("remeshed.vtp")
low = cm.CrackOptions(shape="penny", centre=(7, 7, 4), normal=(0, 0, 1), radius=3)
edge = cm.CrackOptions(shape="through_edge", centre=(0, 7, 10), normal=(0, 0, 1), axis=(1, 0, 0), radius=4)
given = [cm.prescribed_crack(voxels.box, options) for options in (low, edge)]
crack = cm.prepare_crack(given, voxels.box, l_min=1)
sizing = cm.sizing_around(plain, cm.Defects(crack), cm.SizingOptions(l_min=1, l_max=3))
cut, _ = cm.insert_crack(plain, crack, sizing)
gradated, _ = cm.gradate(cut, sizing, crack=crack)
volume, _ = cm.mesh_volume(gradated, sizing)
body, counts = cm.assemble(volume.surface, volume.grain_tets, crack)
print(sorted(name for name in body.face_sets if "LIP" in name))

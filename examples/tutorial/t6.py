"""Tetrahedra fill the grains, and the crack opens.

`mesh_volume` fills grain by grain. `assemble` joins the grains and doubles the nodes of the crack. The
faces of the crack are the sets CRACK_LIP_A and CRACK_LIP_B; its front keeps single nodes.
"""

import craftmesh as cm

gradated, crack = cm.read_surface("gradated.vtp"), cm.read_crack("crack.vtp")
options = cm.SizingOptions(l_min=0.7, l0=1.2, l_max=3, r0=2, r1=6)
sizing = cm.sizing_around(gradated, cm.Defects(crack), options)
volume, report = cm.mesh_volume(gradated, sizing)
body, counts = cm.assemble(volume.surface, volume.grain_tets, crack)
print(body)
print("nodes of the front:", len(body.node_sets["CRACK_FRONT"]))
print("faults:", cm.check(body))
cm.write_tets("volume.vtu", body)

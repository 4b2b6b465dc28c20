"""The crack grows, and cycles are counted.

`front_extensions` gives each node of the front its kink angle and extension. With a law of da/dN it
counts the load cycles. `grow_crack` adds the new strip. The steps t3 to t8 are one loop here, with two
increments.
"""

import craftmesh as cm

voxels = cm.read_labels("labels.npz")
plain, crack = cm.read_surface("remeshed.vtp"), cm.read_crack("crack.vtp")
lengths = cm.SizingOptions(l_min=0.7, l0=1.2, l_max=3, r0=2, r1=6)
material = cm.ModelOptions(material=("isotropic:70000,0.33",), magnitude=1e-3)
paris = cm.GrowthOptions(coefficient=1e-10, exponent=3, share=0.2)
last = None
for increment in range(2):
    sizing = cm.sizing_around(plain, cm.Defects(crack), lengths)
    cut, _ = cm.insert_crack(plain, crack, sizing)
    gradated, _ = cm.gradate(cut, sizing, crack=crack)
    volume, _ = cm.mesh_volume(gradated, sizing)
    body, counts = cm.assemble(volume.surface, volume.grain_tets, crack)
    model, _ = cm.elastic_model(body, material)
    solutions, _ = cm.solve_model(model)
    intensities, _ = cm.stress_intensities(model, solutions)
    columns, report = cm.front_extensions(crack, model, solutions, intensities, paris, last=last)
    grown, growth = cm.grow_crack(crack, voxels, columns, cm.front_frames(body).columns())
    print(f"increment {increment}: area {counts['crack_area']:.1f}, {report['cycles']:.0f} cycles")
    crack, last = grown.crack, cm.counted_front(report, growth)

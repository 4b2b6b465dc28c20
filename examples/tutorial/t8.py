"""K along the front.

`solve_model` finds the displacements. `stress_intensities` integrates J, K and T from them, with an
estimated error at each node. In an infinite body, a penny of radius a under the normal stress s has K_I
= 2 s sqrt(a / pi).
"""

import numpy as np

import craftmesh as cm

model, _ = cm.elastic_model(
    cm.read_tets("volume.vtu"), cm.ModelOptions(material=("isotropic:70000,0.33",), magnitude=1e-3)
)
solutions, _ = cm.solve_model(model)
intensities, _ = cm.stress_intensities(model, solutions)
columns = intensities[""].columns()
slope = np.arctan(0.3)
exact = 2 * 70 * np.cos(slope) ** 2 * np.sqrt(3 / np.pi)
print(f"K_I from {columns['K_I'].min():.0f} to {columns['K_I'].max():.0f}, infinite body {exact:.0f}")
print(f"estimated error up to {100 * columns['error'].max() / exact:.1f} %")

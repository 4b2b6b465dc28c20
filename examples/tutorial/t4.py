"""Edge lengths are a function of the position.

Edges have the length `l_min` at the front and grow to `l_max` far from it. All later stages use the
same function.
"""

import numpy as np

import craftmesh as cm

surface, crack = cm.read_surface("remeshed.vtp"), cm.read_crack("crack.vtp")
options = cm.SizingOptions(l_min=0.7, l0=1.2, l_max=3, r0=2, r1=6)
sizing = cm.sizing_around(surface, cm.Defects(crack), options)
front = crack.points[crack.fronts[0][0]]
for distance in (0, 2, 4, 6):
    point = front + distance * np.array([0, 0, 1])
    print(f"{distance} above the front: edges of {sizing.at(point[None])[0]:.2f}")

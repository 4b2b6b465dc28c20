"""The crack is inserted, and edges get their lengths.

`insert_crack` cuts the crack into the surface of the grains; both then share the edges along which they
meet. `gradate` collapses and splits edges until they have the lengths of the sizing, and keeps each
grain's volume.
"""

import craftmesh as cm

surface, crack = cm.read_surface("remeshed.vtp"), cm.read_crack("crack.vtp")
options = cm.SizingOptions(l_min=0.7, l0=1.2, l_max=3, r0=2, r1=6)
sizing = cm.sizing_around(surface, cm.Defects(crack), options)
cut, report = cm.insert_crack(surface, crack, sizing)
print("area of the crack:", round(report["crack_area"], 2))
gradated, report = cm.gradate(cut, sizing, crack=crack)
print("facets:", len(cut.facets), "become", len(gradated.facets))
print("5, 50 and 95 % of edge length over target:", report["adherence"]["regular"])
cm.write_surface("gradated.vtp", gradated)

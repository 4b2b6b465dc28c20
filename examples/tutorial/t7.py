"""A deck for Abaqus and CalculiX.

A deck has elements, materials, sets, supports and a load. Here the top face moves up by 0.1 % of the
height, and the sides stay free. `check_deck` reads a deck back, with its included files.
"""

import craftmesh as cm

body = cm.read_tets("volume.vtu")
options = cm.DeckOptions(material=("isotropic:70000,0.33",), magnitude=1e-3)
counts = cm.write_deck("model.inp", body, options)
print(counts)
print("faults:", cm.check_deck("model.inp"))

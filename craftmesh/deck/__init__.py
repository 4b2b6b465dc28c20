"""The input deck that Abaqus and CalculiX both read, and its check.

`write_deck` turns an `ElasticModel` and options into text: the mesh and its sets (`mesh_lines`), materials
and sections (`section_lines`), contact (`contact_lines`), and the steps of the load (`step_lines`). All
numbers, rows and names go through `inp_format`. `parts` lays the deck out in parts, `includes` in several
files. `check_deck` and `check_references` read a deck back from its text alone; `limits` has the limits of
the solvers.
"""

"""The input deck that Abaqus and CalculiX both read, and its check.

In come an `ElasticModel` and options, out goes text (`write_deck`): the mesh and its sets (`mesh_lines`),
materials and sections (`section_lines`), contact, and the steps of the load (`step_lines`). All numbers,
rows and names go through `inp_format`. `parts` lays it out in parts, `includes` in several files.
`check_deck` and `check_references` read a deck back from its text alone; what the solvers take stands in
`limits`.
"""

"""What a mesh is made of, and what acts on it.

`model` makes an `ElasticModel` of a mesh and options (`model_options`), which deck and solver share:
`materials` and `orientation` give stiffnesses, `crystals` those of a file's phases, `cohesive` the layers
on grain boundaries, `user_materials` constants for subroutines. `load` says which nodes are held, moved or
under traction, from the rows of `faces`, `lips` and `eigenstrains`; `history` has its steps, `holding` what
keeps bodies in place. `near_field` has the fields at a crack's front in any crystal, `front_parameters` the
intensities along it, and `stress` the stresses of a field of displacements.
"""

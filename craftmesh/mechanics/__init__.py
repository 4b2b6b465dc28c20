"""The materials of a mesh, and the loads on it.

`model` makes an `ElasticModel` of a mesh and options (`model_options`), which deck and solver share.
`materials` and `orientation` give stiffnesses, `crystals` those of a file's phases, `cohesive` the layers
on grain boundaries, `user_materials` constants for subroutines. `load` finds the nodes that are held or
moved and the tractions, from the rows of `faces`, `lips` and `eigenstrains`; `point_fields` are values by
place, of residual stress and temperature; `history` has the steps of a load, and `rigid_body_supports` the
supports that keep bodies in place. `near_field` has the fields at a crack front in any crystal,
`front_parameters` the SIFs along it, and `stress` the stresses of a displacement field.
"""

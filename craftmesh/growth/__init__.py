"""Growth of a crack by one increment.

The stress intensity factors K along the fronts of a crack set its growth. `grow` returns the crack with a
strip of new surface at each front; `grow_crack` calls it with the columns of sif.csv, and finds out why a
crack stops. One record (`front_step`) holds each front point's direction, extension, rate, trust and reason
to stay. `kink_angle` gives the direction, `slip_planes` that along slip planes, `driving` the driving
force, `rates` da/dN, and `extension` the extensions and load cycles. `steps` gives the step's length,
`relaxation` the effect of the front's changing shape on K. `moves` smooths the moves along the front, and
`new_front` lays the strip. `correct` lays the last strip again with the kinks and rates found at its end.
`trust` selects the nodes whose own K counts. `options` has the user's values.
"""

"""Growth of a crack by one increment.

K along the fronts of a crack sets its growth; `grow` returns the crack with a strip of new surface at each
front. One record (`front_step`) holds each front point's direction, extension, rate, trust and reason to
stay. `kink_angle` gives direction and driving force (`criterion_of`), `rates` da/dN, `extension` the
extensions and load cycles. `steps` gives the step's length, `relaxation` the effect of the front's changing
shape on K. `moves` smooths the moves along the front, and `new_front` lays the strip. `correct` lays the
last strip again with the kinks and rates found at its end. `options` has the user's values.
"""

"""Growth of a crack by one increment.

In come a crack and K along its fronts, out comes the crack with a strip of new surface at each front
(`grow`). What each point does in a step is one record (`front_step`): direction, extension, rate, whether
it is trusted, why it stays. `kink_angle` gives the direction and the driving force (`criterion_of`),
`rates` and `extension` how far each point goes and in how many load cycles, `steps` and `relaxation` how
far K lets it over a whole step. `moves` smooths that along the front, `new_front` lays the strip, and
`correct` lays the last one again with what was found at its end. `options` has the user's numbers.
"""

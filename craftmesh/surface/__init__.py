"""The surface: what can be asked of it, and what every stage may do to it.

`connectivity` gives edges and neighbours, `patches` patches, feature edges and what holds each point,
`front` the crack's front, `labels` the grain of a place, `measure` areas, angles, volumes and distances.
`check_surface` says what is broken. `dividing` splits edges, `volumes` brings grains' volumes back, and
`repair` parts facets that intersect. `rounding` says what counts as equal.
"""

"""The surface: what can be asked of it, and what every stage may do to it.

`connectivity` gives edges and neighbours, `patches` patches and feature edges, `front` the crack's front,
`labels` the grain of a place, `measure` areas, angles, volumes and distances. `classification` says what
each vertex is free to do, and `guarded_move` moves vertices within bounds that all stages share.
`check_surface` says what is broken. `dividing` splits edges, `smoothing` draws vertices to their
neighbours, `volumes` brings grains' volumes back, and `repair` parts facets that intersect. `rounding`
says what counts as equal.
"""

"""Surfaces: queries on a surface, and operations on it that several stages share.

`connectivity` gives edges and neighbours, `patches` patches and feature edges, `front` the crack's front,
`labels` the grain at a position, `measure` areas, angles, volumes and distances. `classification` gives
each vertex's freedom to move, and `guarded_move` moves vertices within bounds that all stages share.
`check_surface` lists violated invariants. `facet_subdivision` splits edges, `smoothing` gives the
neighbours that vertices are drawn to, `volumes` restores grain volumes, and `repair` separates facets that
intersect. `rounding` defines which numbers count as equal.
"""

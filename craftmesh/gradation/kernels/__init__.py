"""Numba kernels of the gradation, with one file per operation.

The star is the set of facets that an operation changes. All new facets share one corner, the tip: the new
position of a moved vertex, or the vertex that stays or is new. A witness is the initial position of a
removed or moved vertex, attached to the nearest facet; it is loose while an operation looks for its new
facet. Ranks of vertices are 0 inside a patch, 1 on a line of feature edges, 2 where lines meet or end. An
angle score is a number for both the smallest and the largest angle of a facet; more is better. Codes are
integers that stand for an operation's result (`result_codes`), the end of an edge that may move
(`collapse_rules`), or the common patch and direction of the facets in a grid cell (`sheets`). Corner c is
facets[c // 3, c % 3]; state.first and state.after list the corners at each vertex.
"""

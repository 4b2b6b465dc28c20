"""From the closed surface of one grain to its tetrahedra."""

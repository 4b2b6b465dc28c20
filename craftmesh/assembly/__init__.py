"""One mesh from the grains' tetrahedra, its crack opened."""

"""craftmesh: from labelled microstructures and cracks to gradated tetrahedral finite-element models."""

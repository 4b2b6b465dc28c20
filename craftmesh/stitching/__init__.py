"""One conformal surface from the surfaces of the grains."""

"""Hot loops compiled by numba: check, then apply."""

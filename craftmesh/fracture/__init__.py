"""K, J and T along the front of a solved mesh."""

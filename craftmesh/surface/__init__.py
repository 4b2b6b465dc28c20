"""The surface: what can be asked of it, and what every stage may do to it."""

"""A mesh of the whole model at once, for models in which single grains fail."""

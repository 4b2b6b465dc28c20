"""The whole model at once, where single grains fail."""

"""The whole model meshed in one call, with grains, box planes and crack found again."""

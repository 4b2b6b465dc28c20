"""From labelled voxels to one smoothed surface."""

"""Labelled volumes as they are read and cleaned, and the orientations of their grains.

In comes a file of any format (`reading`), out come `Voxels` whose labels are grains, voids and the outside
(`clean`), and what was changed, in words. `background` decides what label 0 is, `remapping` and
`file_orientations` make grains' ids and orientations of the file's. `voxel_graph` finds connected pieces,
`islands` what one grain encloses, `smoothing` evens boundaries. `generate` and `foam` make volumes.
`options` has the user's numbers.
"""

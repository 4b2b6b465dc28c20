"""Reading, cleaning and generation of labelled volumes, with the orientations of their grains.

`reading` reads a file of any format. `clean` returns `Voxels` whose labels are grains, voids and the
outside, and a report of all changes. `background` finds the meaning of label 0; `remapping` and
`file_orientations` convert the file's ids and orientations to those of grains. `voxel_graph` finds
connected components, `islands` finds bodies enclosed by one grain, and `smoothing` smooths boundaries.
`generate` and `foam` make synthetic volumes. `options` has the user's options.
"""

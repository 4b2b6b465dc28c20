"""From labelled voxels to one smoothed surface.

In come voxels, out comes a conformal surface in model units, free of intersections (`remesh`).
`kernels/marching` walks over the cells between voxel centres: `cell_faces` draws the lines between labels
on a cell's faces, `cell_sheets` spans facets from them, `cell_wedges` parts points at which a grain would
meet itself. Laps then take the steps of the voxels away, and go back wherever they spoil a facet. Last
the volumes of grains and voids are brought back (`surface/volumes`). All numbers are options of the
stage.
"""

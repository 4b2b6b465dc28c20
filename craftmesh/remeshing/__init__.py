"""From labelled voxels to one smoothed surface.

`remesh` turns voxels into a conformal surface in model units without intersections. `kernels/marching`
visits the cells between voxel centres: `cell_faces` makes the segments between labels on a cell's faces,
`cell_sheets` spans facets from the segments, and `cell_wedges` splits points at which a grain would touch
itself. Smoothing passes then remove the voxel steps; a pass is undone at facets that it makes invalid.
Last, `surface/volumes` restores the volumes of grains and voids. All numbers are options of the stage.
"""

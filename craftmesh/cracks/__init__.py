"""Cracks: turn the user's description of each increment into triangulated surfaces with fronts.

A crack is given by numbers (`series`), triangles (`triangulated`), measured points and fronts
(`fitted_surface`), voxels (`voxel_crack`), grain boundaries (`in_boundaries`) or a crystal plane in a grain
(`in_slip_plane`). The result is a `Crack`. `one_sheet` cleans triangles and orients them consistently.
`sheets` splits a crack of several surfaces and joins them again.
`height_parts` finds planes over which a surface is single-valued, and splits surfaces that fold. `prepare`
is the last step: it ends fronts on the box faces that they graze (`grazing_fronts`), merges surfaces that
overlap (`merged_sheets`), and rejects cracks along a box face (`near_faces`) or along each other. Constants
stand at the top of these modules, in units of l_min; `options` has the user's values.
"""

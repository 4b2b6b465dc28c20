"""Cracks: from what a user gives to sheets of triangles with fronts, one increment after another.

A crack comes in as numbers (`series`), triangles (`triangulated`), measured points and fronts
(`measured`), voxels (`voxel_crack`) or grain boundaries (`in_boundaries`), and goes out as a `Crack`.
`one_sheet` cleans triangles and turns them alike; `sheets` parts and joins what is several.
`height_parts` finds planes over which a sheet is a height, and parts one that folds. `prepare` is
the last step: it ends fronts on the faces that they graze (`grazing_fronts`), makes one of sheets that
overlap (`merged_sheets`), and refuses what runs along a face (`near_faces`) or another sheet. The numbers
that decide stand at the heads of these modules, in shares of l_min; `options` has the user's.
"""

"""The page that shows all campaigns of a folder of results.

`case_files` reads what a case has, `measures` makes its numbers, `charts` and `sweeps` compare cases, and
`page` fills the template. `pictures`, `mesh_pictures` and `shown_mesh` draw an increment through `shaded`
and `kernels/raster`, without a screen. `preview` draws a crack before it is meshed, `views` any stage file.
"""

"""The HTML report on all campaigns of a results folder, and pictures.

`case_files` reads the files of a case, `measures` computes its numbers, `charts` and `sweeps` compare
cases, and `page` fills the HTML template. `pictures`, `mesh_pictures` and `shown_mesh` draw an increment
with `shaded` and `kernels/raster`, without a screen. `preview` draws a crack before meshing, and `views`
draws the file of any stage.
"""

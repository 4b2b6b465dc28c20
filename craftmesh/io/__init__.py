"""One module per file format; arrays and the types of craftmesh.types in and out.

`volume_format` tells which format a volume has; each reader returns a `FileVolume` (`file_volume`), which
means nothing yet: `voxels` makes grains of it. `vtk`, `npz`, `stage_npz`, `front_csv` and `json_file` are
the stages' own files. `surface_files`, `point_files` and `model_tables` read what users bring, `text_table`
all of their tables, and `mesh_formats` writes for other programs. A header is held against the bytes there
before memory is taken for it (`declared`).
"""

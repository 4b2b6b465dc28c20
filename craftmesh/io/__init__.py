"""File formats, about one module each: files are read to arrays and types of craftmesh.types, and written.

`volume_format` finds the format of a volume. Each reader returns a `FileVolume` (`file_volume`) with the
file's arrays, of which `voxels` makes grains. `vtk`, `npz`, `stage_npz`, `front_csv` and `json_file` read
and write the stages' own files. `surface_files`, `point_files` and `model_tables` read users' files,
`text_table` their text tables, and `mesh_formats` writes for other programs. Before memory is allocated,
`header_checks` compares the size in a header with the file's size.
"""

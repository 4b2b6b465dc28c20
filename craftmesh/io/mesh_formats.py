"""The formats that a mesh is exported to: one table for the verb, the configuration and the workflow."""

# By the suffix without its dot: the module and its function write(path, mesh), imported when it is called.
MESH_FORMATS = {
    "vtu": ("craftmesh.io.vtu", "write_vtu"),
    "msh": ("craftmesh.io.msh", "write_msh"),
    "e": ("craftmesh.io.exodus", "write_exodus"),
    "exo": ("craftmesh.io.exodus", "write_exodus"),
}

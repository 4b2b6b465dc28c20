"""One module per file format; arrays and the types of craftmesh.types in and out."""

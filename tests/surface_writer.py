"""Triangles written to a surface file, as other tools write them."""

from pathlib import Path


def write_triangles(path, points, triangles):
    """Write points (n, 3) and triangles (m, 3) by the suffix; STL and PLY are binary, in float32."""
    from trimesh import Trimesh

    suffix = Path(path).suffix.lower()
    precision = {"digits": 17} if suffix in (".obj", ".off") else {}
    with open(path, "wb") as stream:
        Trimesh(points, triangles, process=False).export(stream, file_type=suffix[1:], **precision)

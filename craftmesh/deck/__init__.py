"""Parts of the input deck: named sets, mid nodes, materials, and the text itself."""

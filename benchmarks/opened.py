"""The mesh of a volume with its crack opened, by all stages in one process."""


def opened_mesh(voxels, crack, sizes):
    """Return the mesh of voxels with a crack opened, refined round its fronts by SizingOptions `sizes`."""
    from craftmesh.assembly.assemble import assemble
    from craftmesh.gradation.gradate import gradate
    from craftmesh.insertion.insert import insert_crack
    from craftmesh.remeshing.remesh import remesh
    from craftmesh.sizing.sources import Defects, sizing_around
    from craftmesh.tetrahedra.volume import mesh_volume
    from craftmesh.voxels.islands import find_islands

    surface, _ = remesh(voxels)
    defects = Defects(crack)
    inserted, _ = insert_crack(surface, crack, sizing_around(surface, defects, sizes))
    sizing = sizing_around(inserted, defects, sizes)
    gradated, _ = gradate(inserted, sizing, crack=crack)
    volume, _ = mesh_volume(gradated, sizing, islands=find_islands(voxels))
    return assemble(volume.surface, volume.grain_tets)[0]

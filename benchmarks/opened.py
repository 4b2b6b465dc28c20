"""The mesh of a volume with its crack opened, by all stages in one process."""


def opened_mesh(voxels, crack, sizes):
    """Return the mesh of voxels with a crack opened, refined round its fronts by SizingOptions `sizes`."""
    from craftmesh.commands.assemble import complete_mesh
    from craftmesh.gradation.gradate import gradate
    from craftmesh.insertion.insert import insert_crack
    from craftmesh.remeshing.remesh import remesh
    from craftmesh.sizing.sources import Defects, sizing_around
    from craftmesh.tetrahedra.grain_surface import mended
    from craftmesh.tetrahedra.options import TetrahedralizeOptions
    from craftmesh.tetrahedra.record import record_of
    from craftmesh.tetrahedra.tetrahedralize import tetrahedralize
    from craftmesh.voxels.islands import find_islands

    surface, _ = remesh(voxels)
    defects = Defects(crack)
    inserted, _ = insert_crack(surface, crack, sizing_around(defects, surface, sizes))
    sizing = sizing_around(defects, inserted, sizes)
    gradated, _ = gradate(inserted, sizing, crack=crack)
    found = mended(gradated)
    options = TetrahedralizeOptions()
    tets, report = tetrahedralize(found.surface, sizing, find_islands(voxels), options)
    record = record_of(options.mesher, report, [], found.report)
    return complete_mesh(found.surface, tets, record, lambda: sizing, options)[0]

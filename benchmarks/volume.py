"""Tetrahedra side by side: plain TetGen, ours, TetGen with a size map, and mmg3d on the whole volume."""

import importlib.util
import os
import tempfile

import numpy as np
import size_map
from cases import AL1050, COPPER, G26, G100, GRAINS_430, TINY, VOIDS, Case
from measure import compilation, flags, in_child, load, print_table, save, side_by_side, timed, write_json

CASES = {
    "tiny": TINY,
    "g26": G26,
    "g100": G100,
    "al1050": AL1050,
    "copper": COPPER,
    "voids": VOIDS,
    "grains430": GRAINS_430,
}
# degrees
CLEAN = 15
DEFAULT = ("g26", "g100", "al1050", "copper", "voids", "grains430")
COLUMNS = {
    "case": "case",
    "method": "method",
    "tets": "tets",
    "cpu_s": "CPU s",
    "peak_mb": "peak MB",
    "ar_mean": "mean AR",
    "ar_under_5_pct": "AR<5 %",
    "poor_pct": "poor %",
    "poor_shape_factor_pct": "shape<.02 %",
    "poor_dihedral_under_10_pct": "<10 deg %",
    "poor_dihedral_over_160_pct": ">160 deg %",
    "dihedral_min": "least dihedral",
    "dihedral_min_clean": "in clean grains",
    "inside": "L/l inside 5/50/95%",
    "inside_off_pct": "off [.5, 1.6] %",
}


def prepare(case: Case, path: str) -> int:
    """Write the case's gradated surface, sizing and islands; return its number of facets."""
    from craftmesh.gradation.gradate import gradate

    start = case.start()
    surface, _ = gradate(start.surface, start.sizing)
    save(path, (surface, start.sizing, start.islands))
    return len(surface.facets)


def figures_of(points, tets, grain, surface, sizing) -> dict:
    """Return the mesh's quality, and the lengths over target of edges with an end off the surface.

    The first points are those of `surface`. Clean grains have no facet under CLEAN degrees.
    """
    from craftmesh.mesh.quality import quality
    from craftmesh.mesh.shape_measures import shape_measures
    from craftmesh.mesh.tet_connectivity import tet_edges
    from craftmesh.surface.measure import facet_angles
    from craftmesh.types import TetMesh

    measures = quality(TetMesh(points, tets, grain))
    keys = [key for key in COLUMNS if key in measures]
    smallest = facet_angles(surface.points, surface.facets).min(axis=1)
    clean = ~np.isin(grain, surface.sides[smallest < CLEAN])
    lowest = shape_measures(points, np.ascontiguousarray(tets))[clean, 2]
    edges = np.unique(np.sort(tet_edges(tets).reshape(-1, 2), axis=1), axis=0)
    ends = points[edges[edges.max(axis=1) >= len(surface.points)]]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    ratio = length / sizing.at(ends.mean(axis=1))
    return (
        {"tets": len(tets)}
        | {key: measures[key] for key in keys}
        | {
            "dihedral_min_clean": float(lowest.min()) if len(lowest) else None,
            "inside": [float(v) for v in np.percentile(ratio, (5, 50, 95))] if len(ratio) else [],
            "inside_off_pct": float(100 * ((ratio < 0.5) | (ratio > 1.6)).mean()) if len(ratio) else None,
        }
    )


def merged(surface, grain_tets) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points, tets and grains of the whole model, the crack closed; surface points come first."""
    points, tets, grain, count = [surface.points], [], [], len(surface.points)
    for one in grain_tets:
        ids = np.concatenate([one.nodes, count + np.arange(len(one.interior))])
        points.append(one.interior)
        tets.append(ids[one.tets])
        grain.append(np.full(len(one.tets), one.grain, np.int32))
        count += len(one.interior)
    return np.concatenate(points), np.concatenate(tets), np.concatenate(grain)


def meshed(surface, sizing, islands, changes: dict) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the tetrahedra of all grains, made by one worker process with the options `changes`."""
    from craftmesh.tetrahedra.options import TetrahedralizeOptions
    from craftmesh.tetrahedra.tetrahedralize import tetrahedralize

    grain_tets, _ = tetrahedralize(surface, sizing, TetrahedralizeOptions(**changes), islands)
    return merged(surface, grain_tets)


def run_grains(path: str, changes: dict) -> dict:
    """Mesh a prepared case grain by grain."""
    surface, sizing, islands = load(path)
    mesh, cost = timed(meshed, surface, sizing, islands, changes)
    return cost | figures_of(*mesh, surface, sizing)


def run_whole(path: str, changes: dict) -> dict:
    """Mesh a prepared case grain by grain, then as a whole: its surface gives way and is smoothed."""
    surface, sizing, islands = load(path)
    mesh, cost = timed(whole, surface, sizing, islands, changes)
    return cost | figures_of(*mesh, sizing)


def whole(surface, sizing, islands, changes: dict):
    """Return (points, tets, grain, surface) as decks have them, the crack closed."""
    from craftmesh.tetrahedra.options import TetrahedralizeOptions
    from craftmesh.tetrahedra.volume import mesh_volume

    found, _ = mesh_volume(surface, sizing, TetrahedralizeOptions(**changes), islands)
    return *merged(found.surface, found.grain_tets), found.surface


def run_size_map(path: str, changes: dict) -> dict:
    """Mesh a prepared case grain by grain with TetGen's program and a size map."""
    os.environ[size_map.SIZING] = path
    return run_grains(path, changes | {"mesher": size_map.MESHER})


def run_mmg3d(path: str, changes: dict) -> dict:
    """Improve plain TetGen's mesh of a prepared case with mmg3d; the cost is that of both."""
    surface, sizing, islands = load(path)
    mesh, cost = timed(improved_by_mmg3d, surface, sizing, islands, changes)
    return cost | figures_of(*mesh)


def improved_by_mmg3d(surface, sizing, islands, changes: dict):
    """Return (points, tets, grain, surface, sizing) with the surface's facets kept by mmg3d."""
    import mmgpy

    points, tets, grain = meshed(surface, sizing, islands, changes)
    mesh = mmgpy.MmgMesh3D()
    mesh.set_mesh_size(vertices=len(points), tetrahedra=len(tets), triangles=len(surface.facets))
    mesh.set_vertices(points)
    mesh.set_tetrahedra(tets.astype(np.int32), grain)
    _, reference = np.unique(np.column_stack([surface.sides, surface.kind]), axis=0, return_inverse=True)
    mesh.set_triangles(np.array(surface.facets), reference.reshape(-1).astype(np.int32) + 1)
    mesh.set_required_triangles(np.arange(len(surface.facets), dtype=np.int32))
    mesh.set_field("metric", sizing.at(points)[:, None])
    mesh.remesh(verbose=-1, nosurf=True, opnbdy=True, hgrad=-1.0)
    tets, grain = mesh.get_tetrahedra_with_refs()
    points = mesh.get_vertices()
    return *surface_first(points, np.asarray(tets, np.int64), np.asarray(grain, np.int32), surface), sizing


def surface_first(points, tets, grain, surface):
    """Return the mesh with the surface's points first; mmg keeps them, but within rounding only."""
    from scipy.spatial import cKDTree

    distance, place = cKDTree(points).query(surface.points)
    if distance.max() > 1e-6 * np.ptp(surface.points):
        raise ValueError(f"mmg3d moved a point of the surface by {distance.max():.3g}")
    rest = np.setdiff1d(np.arange(len(points)), place)
    new = np.empty(len(points), np.int64)
    new[np.concatenate([place, rest])] = np.arange(len(points))
    return np.concatenate([surface.points, points[rest]]), new[tets], grain, surface


PLAIN = {"interior_points": False, "optimise": False}


def methods_of(peers: bool) -> dict[str, tuple]:
    """Return what is measured by name: a function of a prepared case, and its other arguments."""
    methods: dict[str, tuple] = {"TetGen": (run_grains, PLAIN), "craftmesh": (run_whole, {})}
    if peers and not size_map.missing():
        methods["TetGen + size map"] = (run_size_map, PLAIN)
    elif peers:
        print(f"TetGen with a size map: skipped, {size_map.missing()}")
    if peers and importlib.util.find_spec("mmgpy"):
        methods["TetGen + mmg3d"] = (run_mmg3d, PLAIN)
    elif peers:
        print("mmg3d: skipped, the package mmgpy is not installed")
    return methods


def main() -> None:
    arguments = flags(__doc__, list(CASES)).parse_args()
    content: dict = {}
    with tempfile.TemporaryDirectory() as folder:
        in_child(prepare, TINY, f"{folder}/warm-up")
        in_child(run_whole, f"{folder}/warm-up", {})
        if arguments.cold:
            content["jit"] = compilation(run_whole, f"{folder}/warm-up", {})
        cases = {name: CASES[name] for name in arguments.case or DEFAULT}
        methods, content["rows"] = methods_of(not arguments.no_peers), []
        for row in side_by_side(cases, prepare, methods, folder, arguments.runs):
            content["rows"].append(row)
            write_json(arguments.json, content)
        print_table(content["rows"], COLUMNS)
    write_json(arguments.json, content)


if __name__ == "__main__":
    main()

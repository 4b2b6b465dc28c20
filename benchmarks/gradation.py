"""Gradation side by side with mmgs: speed, memory, sizes, angles and intersections, in one table."""

import importlib.util
import sys
import tempfile

import numpy as np
from cases import G26, G100, GRAINS_200, GRAINS_430, TINY, Case, generated
from measure import (
    ChildFailed,
    compilation,
    flags,
    in_child,
    load,
    print_table,
    repeated,
    save,
    side_by_side,
    timed,
    write_json,
)

CASES = {
    "tiny": TINY,
    "g26": G26,
    "g100": G100,
    "grains200": GRAINS_200,
    "grains430": GRAINS_430,
}
DEFAULT = ("g26", "g100", "grains200", "grains430")
# edge of the cube and grains, all of the same mean grain size: about .1, .4, 1.5 and 6 million facets
SCALING = ((61, 29), (97, 116), (150, 430), (238, 1717))
COLUMNS = {
    "case": "case",
    "method": "method",
    "facets_in": "facets in",
    "facets_out": "out",
    "cpu_s": "CPU s",
    "peak_mb": "peak MB",
    "operations_per_s": "ops/s",
    "regular_far": "far regular 5/50/95%",
    "junction_far": "far junction",
    "front": "front (of l_min)",
    "smallest_angle": "smallest angle",
    "under_12": "under 12 deg",
    "intersections": "intersections",
}


def prepare(case: Case, path: str) -> int:
    """Write the case's start and return its number of facets."""
    start = case.start()
    save(path, start)
    return len(start.surface.facets)


def figures_of(surface, sizing) -> dict:
    """Return how a gradated surface keeps sizes and angles, and its pairs of facets that intersect."""
    from craftmesh.gradation.report import size_adherence
    from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
    from craftmesh.surface.measure import facet_angles

    adherence = size_adherence(surface, sizing)
    smallest = facet_angles(surface.points, surface.facets).min(axis=1)
    return {
        "facets_out": len(surface.facets),
        **{key: adherence[key] for key in ("regular_far", "junction_far", "front")},
        "smallest_angle": float(smallest.min()),
        "under_12": int((smallest < 12).sum()),
        "intersections": len(intersecting_pairs(surface.points, surface.facets.astype(np.int64))),
    }


def run_ours(path: str, warm_up: str | None) -> dict:
    """Gradate a prepared case after a run on `warm_up`, which takes the kernels from the cache."""
    from craftmesh.gradation.gradate import gradate

    start = load(path)
    if warm_up:
        tiny = load(warm_up)
        gradate(tiny.surface, tiny.sizing)
    (surface, report), cost = timed(gradate, start.surface, start.sizing)
    operations = sum(report["operations"].values())
    cost["operations_per_s"] = operations / max(cost["cpu_s"], 1e-9)
    return cost | {"facets_in": len(start.surface.facets)} | figures_of(surface, start.sizing)


def run_mmgs(path: str) -> dict:
    """Remesh a prepared case with mmgs: references are the patches, sizes Eq. 3 at the vertices."""
    start = load(path)
    surface, cost = timed(remeshed_by_mmgs, start.surface, start.sizing)
    return cost | {"facets_in": len(start.surface.facets)} | figures_of(surface, start.sizing)


def remeshed_by_mmgs(surface, sizing):
    """Return the surface as mmgs leaves it, its sides and kinds found again by the references."""
    import mmgpy

    from craftmesh.types import Surface

    rows, reference = np.unique(np.column_stack([surface.sides, surface.kind]), axis=0, return_inverse=True)
    mesh = mmgpy.MmgMeshS()
    mesh.set_mesh_size(vertices=len(surface.points), triangles=len(surface.facets))
    mesh.set_vertices(np.array(surface.points))
    mesh.set_triangles(np.array(surface.facets), reference.reshape(-1).astype(np.int32) + 1)
    mesh.set_field("metric", sizing.at(surface.points)[:, None])
    mesh.remesh(verbose=-1, hausd=0.15 * sizing.l0, hgrad=-1.0)
    facets, reference = mesh.get_triangles_with_refs()
    found = rows[np.asarray(reference).reshape(-1) - 1]
    return Surface(mesh.get_vertices(), facets, found[:, :2], found[:, 2])


def methods_of(warm_up: str, peers: bool) -> dict[str, tuple]:
    """Return what is measured by name: a function of a prepared case, and its other arguments."""
    methods: dict[str, tuple] = {"craftmesh": (run_ours, warm_up)}
    if peers and importlib.util.find_spec("mmgpy"):
        methods["mmgs"] = (run_mmgs,)
    elif peers:
        print("mmgs: skipped, the package mmgpy is not installed")
    return methods


def scaling(folder: str, runs: int, with_six_million: bool) -> dict:
    """Return facets and CPU seconds of cubes of one grain size, and the exponent fitted to them."""
    found = []
    for edge, grains in SCALING if with_six_million else SCALING[:-1]:
        path = f"{folder}/scaling"
        print(f"scaling, {grains} grains ...", file=sys.stderr)
        in_child(prepare, Case(generated, (edge, grains)), path)
        row = repeated(runs, run_ours, path, f"{folder}/tiny")
        if "failed" in row:
            raise ChildFailed(row["failed"])
        found.append({key: row[key] for key in ("facets_in", "facets_out", "cpu_s", "peak_mb")})
    facets, seconds = (np.log([row[key] for row in found]) for key in ("facets_in", "cpu_s"))
    return {"rows": found, "exponent": float(np.polyfit(facets, seconds, 1)[0])}


def main() -> None:
    parser = flags(__doc__, list(CASES))
    parser.add_argument("--scaling", action="store_true", help="growth with .1, .4 and 1.5 million facets")
    parser.add_argument(
        "--six-million", action="store_true", help="with 6 million facets in the growth too"
    )
    arguments = parser.parse_args()
    names = arguments.case or (() if arguments.scaling else DEFAULT)
    content = {}
    with tempfile.TemporaryDirectory() as folder:
        in_child(prepare, TINY, f"{folder}/tiny")
        if arguments.cold:
            content["jit"] = compilation(run_ours, f"{folder}/tiny", None)
        if names:
            methods = methods_of(f"{folder}/tiny", not arguments.no_peers)
            cases = {name: CASES[name] for name in names}
            content["rows"] = []
            for row in side_by_side(cases, prepare, methods, folder, arguments.runs):
                content["rows"].append(row)
                write_json(arguments.json, content)
            print_table(content["rows"], COLUMNS)
        if arguments.scaling:
            content["scaling"] = scaling(folder, arguments.runs, arguments.six_million)
            for row in content["scaling"]["rows"]:
                print(f"{row['facets_in']} facets: {row['cpu_s']:.2f} CPU s, {row['peak_mb']:.0f} MB")
            print(f"CPU s grow with facets to the power {content['scaling']['exponent']:.2f}")
    write_json(arguments.json, content)


if __name__ == "__main__":
    main()

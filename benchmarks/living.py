"""Growing pennies: each increment renewed (reuse) against the same increment made anew (never).

`python benchmarks/living.py CASE INCREMENTS` prints a row an increment: shares of the elements renewed and
kept to the bit, CPU seconds from crack to mesh of both ways, and the quality of both meshes.
"""

import argparse
import json
from pathlib import Path

import numpy as np
from measure import cpu_seconds

from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.prepare import prepare_crack
from craftmesh.cracks.series import prescribed_crack
from craftmesh.mesh.shape_measures import is_flat, is_poor, shape_measures
from craftmesh.progress import silent
from craftmesh.remeshing.remesh import remesh
from craftmesh.renewal.options import RenewOptions
from craftmesh.renewal.renew import Renewed, StageOptions, history_of, mesh_from_scratch, renew_mesh
from craftmesh.sizing.sizing import SizingOptions
from craftmesh.sizing.sources import Defects, sizing_around
from craftmesh.surface.measure import total_area
from craftmesh.types import Crack, Surface, TetMesh
from craftmesh.voxels.generate import generate
from craftmesh.voxels.options import GenerateOptions

SPOKES, BEND = 160, 120.0  # points of a ring of a bowl; radius squared over height
SIZES = SizingOptions(l_min=0.5, l0=1, l_max=3, r0=8, r1=16)
# Voxels along an axis, grains, and the penny: shape, centre, normal, first radius, growth an increment.
CASES = {
    "tiny": (16, 3, ("penny", (8.0, 8.0, 8.2), (0.0, 0.0, 1.0), 3.0, 0.4)),
    "g27": (60, 27, ("penny", (30.0, 30.0, 30.2), (0.0, 0.0, 1.0), 15.0, 0.8)),
    "g125": (60, 125, ("penny", (0.0, 30.0, 30.2), (0.0, 0.0, 1.0), 8.0, 0.5)),
    "tilted": (60, 27, ("penny", (30.0, 30.0, 30.2), (0.3, 0.2, 1.0), 13.0, 0.8)),
    "bowl": (60, 27, ("bowl", (30.0, 30.0, 30.2), (0.1, 0.2, 1.0), 13.0, 0.8)),
    "g430": (150, 430, ("penny", (0.0, 75.0, 75.2), (0.0, 0.0, 1.0), 15.0, 1.5)),
}


def quality(mesh: TetMesh) -> dict:
    """Return the mean aspect ratio, counts of elements by fault, and the area of the crack."""
    measures = shape_measures(mesh.points, mesh.tets)
    return {
        "tets": len(measures),
        "mean_ar": round(float(measures[:, 1].mean()), 4),
        "over_5": int((measures[:, 1] > 5).sum()),
        "poor": int(is_poor(measures).sum()),
        "flat": int(is_flat(measures).sum()),
        "crack_area": round(total_area(mesh.points, mesh.outward_triangles("CRACK_LIP_A")), 2),
    }


def kept(before: TetMesh, found: Renewed) -> float:
    """Return the share of elements that are those of `before`, with the same numbers and coordinates."""
    rows = np.flatnonzero(found.numbers.elements >= 0)
    rows = rows[found.numbers.elements[rows] == rows]
    same = (before.points[before.tets[rows]] == found.mesh.points[found.mesh.tets[rows]]).all(axis=(1, 2))
    same &= (before.tets[rows] == found.mesh.tets[rows]).all(axis=1)
    return float(same.sum() / len(found.mesh.tets))


def crack_of(plain: Surface, case: str, increment: int) -> Crack:
    """Return the crack of an increment of a case."""
    shape, centre, normal, radius, step = CASES[case][2]
    radius += step * increment
    if shape == "bowl":
        return bowl(centre, normal, radius, step)
    options = CrackOptions(shape="penny", centre=centre, normal=normal, radius=radius)
    return prepare_crack([prescribed_crack(plain.box, options)], plain.box, l_min=0.5)


def bowl(centre: tuple, normal: tuple, radius: float, step: float) -> Crack:
    """Return a paraboloid of rings `step` apart, so that a larger one contains all smaller ones."""
    axis = np.array(normal) / np.linalg.norm(normal)
    across = np.linalg.svd(axis[None])[2][1:]
    rings = np.arange(radius, 0, -step)[::-1]
    turn = np.linspace(0, 2 * np.pi, SPOKES, endpoint=False)
    flat = rings[:, None, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    flat = np.concatenate([np.zeros((1, 2)), flat.reshape(-1, 2)])
    points = np.array(centre) + flat @ across + np.outer((flat**2).sum(axis=1) / BEND, axis)
    one = np.arange(SPOKES)
    after = np.roll(one, -1)
    triangles = [np.stack([np.zeros(SPOKES, int), 1 + one, 1 + after], axis=1)]
    for ring in range(len(rings) - 1):
        low = 1 + ring * SPOKES
        a, b, c, d = low + one, low + after, low + SPOKES + after, low + SPOKES + one
        triangles += [np.stack([a, d, c], axis=1), np.stack([a, c, b], axis=1)]
    front = 1 + (len(rings) - 1) * SPOKES + np.append(one, 0)
    return Crack(points, np.concatenate(triangles), (front,))


def run(case: str, increments: int, with_anew: bool, most: float) -> list[dict]:
    """Return a row an increment of a case."""
    size, grains, _ = CASES[case]
    voxels = generate(GenerateOptions(shape=(size,) * 3, grains=grains, seed=1))
    plain, _ = remesh(voxels)
    options = StageOptions(renew=RenewOptions(reuse="auto", most_renewed=most))
    rows, mesh, history = [], None, None
    for increment in range(increments):
        crack = crack_of(plain, case, increment)
        sizing = sizing_around(plain, Defects(crack), SIZES)
        row: dict = {"increment": increment}
        start = cpu_seconds()
        if mesh is None:
            mesh, *_ = mesh_from_scratch(plain, crack, sizing, options, None, 1, silent)
            history = history_of(mesh, sizing)
        else:
            found = renew_mesh(mesh, history, plain, crack, sizing, options)
            row |= found.report["renewed"] | {"kept": round(kept(mesh, found), 4)}
            row["notes"] = list(found.warnings)
            mesh, history = found.mesh, found.history
        row |= {"cpu": round(cpu_seconds() - start, 2)} | quality(mesh)
        if with_anew and increment:
            start = cpu_seconds()
            other, *_ = mesh_from_scratch(plain, crack, sizing, options, None, 1, silent)
            row["anew"] = {"cpu": round(cpu_seconds() - start, 2)} | quality(other)
        print(json.dumps(row), flush=True)
        rows.append(row)
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("case", choices=CASES)
    parser.add_argument("increments", type=int)
    parser.add_argument("--anew", action="store_true", help="make each increment anew, too, to compare")
    parser.add_argument("--most", type=float, default=0.5, help="most_renewed")
    parser.add_argument("--json", type=Path, help="write the rows to this file")
    arguments = parser.parse_args()
    rows = run(arguments.case, arguments.increments, arguments.anew, arguments.most)
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()

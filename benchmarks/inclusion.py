"""Stress of a hot ball in an infinite body, from voxels to the solver, against Eshelby's field.

The outer faces get the displacements of the infinite body. Errors are the largest of the six components, in
% of the pressure in the ball. This stress is then the residual stress of a penny in the plane of the ball's
middle, in a mesh without the ball.
"""

import argparse

import exact_cracks
import fracture
import numpy as np
from exact_cracks import POISSON, YOUNG
from fracture import CENTRE, FINE, HEAT, ball
from measure import print_table
from opened import opened_mesh

CRACK = 2.0  # radius of a penny in a corner, twice this from its faces: meshes of the stages have a crack
INNER, OUTER = 0.8, 1.2  # radii off the faceted boundary
COLUMNS = {name: name for name in ("where", "nodes", "mean", "median", "rms", "max")}


def solved(radius: float, edge: float):
    """Return points, stresses (n, 3, 3) and grains of a body with a hot ball, and the ball."""
    from dataclasses import replace

    from craftmesh.cracks.options import CrackOptions
    from craftmesh.cracks.series import crack_of_increment
    from craftmesh.mechanics.load import Fixed, Load
    from craftmesh.mechanics.materials import COMPONENT
    from craftmesh.mechanics.model import elastic_model
    from craftmesh.mechanics.model_options import ModelOptions
    from craftmesh.mechanics.stress import grain_stress
    from craftmesh.sizing.sizing import SizingOptions
    from craftmesh.solve.solve import SolveOptions, solve
    from craftmesh.types import Voxels

    count = round(4 * radius)
    off = np.moveaxis(np.indices((count,) * 3), 0, -1) + 0.5 - (count / 2 + 0.1)
    labels = 1 + (np.linalg.norm(off, axis=-1) < radius)
    voxels = Voxels(labels.astype(np.int32), np.ones(3), np.zeros(3))
    penny = CrackOptions(shape="penny", centre=(count - 2 * CRACK,) * 3, radius=CRACK)
    sizes = SizingOptions(l_min=edge, l0=1.0, l_max=1.5 * edge, r0=3 * CRACK, r1=10 * CRACK)
    mesh = opened_mesh(voxels, crack_of_increment(penny, 0, voxels.box, None), sizes)
    material, strain = (f"isotropic:{YOUNG!r},{POISSON!r}",), (f"2=isotropic:{HEAT!r}",)
    options = ModelOptions(material=material, load="none", eigenstrain=strain)
    model, _ = elastic_model(mesh, options, phases=np.arange(3))
    mesh, hot = model.mesh, ball(model.mesh)
    planes = [mesh.node_sets[f"{axis}{end}"] for axis in "XYZ" for end in ("MIN", "MAX")]
    outer = np.unique(np.concatenate(planes))
    moved = exact_cracks.round_inclusion(mesh.points[outer], *hot, HEAT)
    held = tuple(Fixed(outer, axis, moved[:, axis]) for axis in range(3))
    model = replace(model, load=Load(held, heat=1.0))
    found = grain_stress(model, solve(model, SolveOptions(tolerance=FINE))[0].displacement)
    grain = np.zeros(len(found.node), int)
    grain[found.tets] = mesh.grain[:, None]
    points = mesh.points[found.node]
    kept = np.linalg.norm(points - penny.centre, axis=1) > 3 * CRACK
    return points[kept], found.stress[:, COMPONENT][kept], grain[kept], hot


def penny(points, stress, middle, size: float) -> dict:
    """Return the errors of K of a penny beside the ball, in % of the largest, as `fracture.errors` does."""

    from craftmesh.fracture.parameters import fracture_parameters
    from craftmesh.mechanics.materials import COLUMN, ROW
    from craftmesh.mechanics.near_field import as_tensor
    from craftmesh.mechanics.point_fields import PointField

    radius = size / 4
    shift = CENTRE - middle - [1.5 * radius + size, 0, 0]
    field = PointField(points + shift, (0, 1, 2), stress[:, ROW, COLUMN])
    crack = {"shape": "penny", "centre": tuple(CENTRE), "radius": radius}
    case = fracture.Case(crack, {}, size=radius, field=field)
    model = fracture.model_of(fracture.meshed(case, radius / 8), case)
    tensor = as_tensor(model.stiffness()[:1])[0]
    moved = fracture.solved(case, model, np.zeros((3, 3)), tensor).displacement
    lips = fracture.on_lips(case, model.mesh, None)
    found, _ = fracture_parameters(model.mesh, moved, model.grains, model.stiffness(), lips=lips)
    exact = exact_cracks.heated(radius, CENTRE, middle + shift, size, HEAT)
    return {"case": "penny"} | fracture.errors(model.mesh, found, exact, by_formula=False)


def rows(points, stress, grain, middle, size: float) -> list[dict]:
    """Return the errors inside the ball and outside, with and without nodes near its boundary."""
    distance = np.linalg.norm(points - middle, axis=1)
    inside, out = grain == 2, (points - middle) / distance[:, None]
    pressure = 2 * YOUNG * HEAT / (3 * (1 - POISSON))
    along = np.where(inside, -pressure, -pressure * (size / distance) ** 3)
    across = np.where(inside, -pressure, -along / 2)
    exact = (
        across[:, None, None] * np.eye(3) + (along - across)[:, None, None] * out[:, :, None] * out[:, None]
    )
    off = 100 * np.abs(stress - exact).max(axis=(1, 2)) / pressure
    mean = 100 * (np.trace(stress - exact, axis1=1, axis2=2) / 3 / pressure)
    groups = {
        "inside": inside,
        f"inside, up to {INNER} radii": inside & (distance < INNER * size),
        "outside": ~inside,
        f"outside, from {OUTER} radii": ~inside & (distance > OUTER * size),
    }
    return [
        {"where": name, "nodes": int(of.sum()), "mean": mean[of].mean(), "median": np.median(off[of])}
        | {"rms": np.sqrt((off[of] ** 2).mean()), "max": off[of].max()}
        for name, of in groups.items()
    ]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--radius", type=float, default=12.0, help="of the ball, in voxels (12)")
    parser.add_argument("--edge", type=float, default=1.2, help="shortest edges, in voxels (1.2)")
    arguments = parser.parse_args()
    points, stress, grain, hot = solved(arguments.radius, arguments.edge)
    print_table(rows(points, stress, grain, *hot), COLUMNS)
    print_table(
        [penny(points, stress, *hot)], {name: name for name in ("case", "K_I", "K_II", "K_III", "root")}
    )

"""A crack that grows through columnar grains, gradated meshes beside uniform ones: the paper's third model.

Both meshes of an increment have one crack; the kink angles found on the gradated one say how it goes on, so
that single increments can be compared with the uniform mesh, which takes most of the time.
"""

import argparse
import json
import tempfile
from pathlib import Path

import numpy as np
from measure import in_child, load, print_table, save, timed, write_json
from opened import opened_mesh

# Micrometres. The box holds as many elements of 1.5 as the paper's uniform meshes have, and the last crack.
EDGE, VOXELS, GRAINS = 1.5, (86, 50, 52), 26
COLUMNS_RATIO = 3.0  # length of the grains along z over their width
RADIUS, GROWN = 18.0, 5
NEAR, FAR = 1.5, 3.6
# Eq. 3's own radii: 8 and 16 edges of the uniform mesh.
REFINED, TRANSITION = 8 * EDGE, 16 * EDGE
MATERIAL = "cubic:204600,137700,126200"  # 316 steel: H. M. Ledbetter, Phys. Stat. Sol. A 85 (1984)
STRAIN = 2e-3
# Nodes so near to the ends of the front, in edges, are left out: K has no meaning at a free face.
END = 2.0
COLUMNS = {
    "increment": "increment",
    "tets": "tets uniform/gradated",
    "fewer": "fewer %",
    "unknowns": "unknowns",
    "ar_mean": "mean AR",
    "ar_under_5_pct": "AR<5 %",
    "poor_pct": "poor %",
    "mesh_s": "mesh CPU s",
    "solve_s": "solve CPU s",
    "peak_mb": "peak MB",
    "kink": "kink angles: least/largest",
    "off": "kink angle off: mean/median/95%/max",
    "off_ends": "at the ends: max",
}


def volume():
    """Return the columnar grains."""
    from craftmesh.voxels.generate import GenerateOptions, generate

    return generate(
        GenerateOptions(
            shape=VOXELS, spacing=(EDGE,) * 3, grains=GRAINS, columnar_ratio=COLUMNS_RATIO, seed=1
        )
    )


def first_crack():
    """Return the semicircle in the middle of the face y = 0."""
    from craftmesh.cracks.options import CrackOptions
    from craftmesh.cracks.series import prescribed_crack

    box = volume().box
    centre = (float(box[1, 0]) / 2, 0.0, float(box[1, 2]) / 2)
    return prescribed_crack(CrackOptions(shape="penny", centre=centre, radius=RADIUS), 0, box)


def run(crack_file: str, near: float, far: float, target: str | None) -> dict:
    """Mesh and solve with edges `near` and `far`; return figures and the kink angles along the front.

    target: a file for the crack that has grown by one increment.
    """
    from craftmesh.growth.extension import CrackFronts, kinks_and_extensions
    from craftmesh.growth.grow import grow
    from craftmesh.growth.moves import FrontExtensions
    from craftmesh.growth.options import GrowthOptions, SmoothingOptions
    from craftmesh.growth.steps import crack_size
    from craftmesh.mesh.front_frames import front_frames
    from craftmesh.mesh.quality import quality
    from craftmesh.sizing.sizing import SizingOptions

    voxels, crack = volume(), load(crack_file)
    sizes = SizingOptions(l_min=near, l0=max(near, EDGE), l_max=far, r0=REFINED, r1=TRANSITION)
    mesh, meshing = timed(opened_mesh, voxels, crack, sizes)
    measures = quality(mesh)
    figures = {"tets": len(mesh.tets)} | {key: measures[key] for key in COLUMNS.keys() & measures.keys()}
    (k, model), solving = timed(intensities_of, mesh, voxels.orientations)
    frames = front_frames(model.mesh)
    growth = kinks_and_extensions(k, CrackFronts(crack_size(crack, voxels.box)), GrowthOptions(share=0.25))
    if target:
        trusted = np.ones(len(k), bool)
        along = FrontExtensions(
            frames.points, frames.normal, frames.binormal, growth.kink_angle, growth.extension, trusted
        )
        save(target, grow(crack, along, voxels.box, SmoothingOptions()))
    return figures | {
        "unknowns": 3 * len(model.mesh.points),
        "mesh_s": meshing["cpu_s"],
        "solve_s": solving["cpu_s"],
        "peak_mb": solving["peak_mb"],
        "s": (frames.s / frames.s[-1]).tolist(),
        "end": END * float(np.median(np.diff(frames.s)) / frames.s[-1]),
        "pierce": frames.pierce.tolist(),
        "kink_angle": np.degrees(growth.kink_angle).tolist(),
    }


def intensities_of(mesh, orientations) -> tuple:
    """Return K_I, K_II, K_III (n, 3) along the front of a mesh pulled along z, and its model."""
    from craftmesh.commands.fracture import intensities, loaded_planes
    from craftmesh.fracture.parameters import fracture_parameters
    from craftmesh.mechanics.model import elastic_model
    from craftmesh.mechanics.model_options import ModelOptions
    from craftmesh.solve.solve import solve

    options = ModelOptions(material=(MATERIAL,), load="strain", magnitude=STRAIN, quarter_points=True)
    model, _ = elastic_model(mesh, options, orientations)
    displacement = solve(model)[0].displacement
    planes = loaded_planes(model.load)
    found, _ = fracture_parameters(model.mesh, displacement, model.grains, model.stiffness(), loaded=planes)
    return intensities(found), model


def alone(increment: int, gradated: dict) -> dict:
    """Return a row of the table for an increment without a uniform mesh."""
    row = {key: [None, gradated[key]] for key in COLUMNS.keys() & gradated.keys()}
    return {"increment": increment} | row


def compared(increment: int, gradated: dict, uniform: dict) -> dict:
    """Return a row of the table: both meshes' figures, and by how much the kink angles differ, degrees."""
    s, angle = np.array(uniform["s"]), np.array(uniform["kink_angle"])
    off = np.abs(np.interp(s, gradated["s"], gradated["kink_angle"]) - angle)
    end = max(uniform["end"], gradated["end"])
    inner = (s > end) & (s < 1 - end)
    row = {"increment": increment, "fewer": 100 * (1 - gradated["tets"] / uniform["tets"])}
    for key in COLUMNS.keys() & uniform.keys():
        row[key] = [uniform[key], gradated[key]]
    part = off[inner]
    return row | {
        "kink": [float(angle[inner].min()), float(angle[inner].max())],
        "off": [float(value) for value in (part.mean(), *np.percentile(part, (50, 95, 100)))],
        "off_ends": float(off[~inner].max()),
    }


def figures_of(folder: Path, increment: int, scale: float, gradated: bool) -> dict:
    """Return the figures of one mesh of an increment, from its file where they were found before."""
    name = "gradated" if gradated else "uniform"
    done = folder / f"{increment}_{name}.json"
    if not done.exists():
        crack = folder / f"{increment}.crack"
        sizes = (scale * NEAR, scale * (FAR if gradated else NEAR))
        grows = gradated and increment < GROWN
        target = str(folder / f"{increment + 1}.crack") if grows else None
        write_json(done, in_child(run, str(crack), *sizes, target))
    return json.loads(done.read_text())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures to this file")
    parser.add_argument("--folder", type=Path, help="keep all figures here, and go on where they stopped")
    parser.add_argument(
        "--uniform", type=int, action="append", help="only these increments have a uniform mesh too (all)"
    )
    parser.add_argument("--scale", type=float, default=1.0, help="of both edge lengths (default 1)")
    arguments = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.folder or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        save(str(folder / "0.crack"), in_child(first_crack))
        for increment in range(GROWN + 1):
            gradated = figures_of(folder, increment, arguments.scale, gradated=True)
            if increment in (arguments.uniform or range(GROWN + 1)):
                uniform = figures_of(folder, increment, arguments.scale, gradated=False)
                rows.append(compared(increment, gradated, uniform))
            else:
                rows.append(alone(increment, gradated))
            write_json(arguments.json, {"rows": rows})
    print_table(rows, COLUMNS)


if __name__ == "__main__":
    main()

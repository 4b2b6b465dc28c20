"""Wings of a main crack in compression, whose lips rub: K and path beside a solution in the plane.

The crack goes through a plate whose faces are held along their normals, so that the strain is plane.
"""

from pathlib import Path

import numpy as np
import wing_cracks

from grown.campaigns import Check, columns, front, grown
from grown.closed import MODE_II
from grown.inclined import distance_to_path

WIDTH, THICKNESS, HALF, FRICTION = 120.0, 3.0, 4.0, 0.3
CENTRE, END = WIDTH / 2 + 0.1, (1 + 1j) / np.sqrt(2)  # of the main crack; its end is over HALF
STRESS = (0.0, -1.0, 0.0)
EDGE, STEP = HALF / 8, HALF / 4
STEPS = 4
MOST_K = 0.06  # found: 0.028, 0.032, 0.043, 0.054 in four steps; 0.021 after the first with half the edges
CONFIG = """
generate: {{shape: [40, 2, 40], spacing: [3.0, 1.5, 3.0], grains: 1}}
import: {{allow_single_grain: true}}
sizing: {{l0: {l0}, l_min: {edge}, l_max: 12.0, r0: 5.0, r1: 40.0}}
cracks: {{crack: {{shape: surface, file: main.vtp}}}}
grow: {{extension: {step}}}
inp:
  material: ["isotropic:70000,0.3"]
  faces: [YMIN.y=fixed, YMAX.y=fixed, ZMIN.z=stress:-1, ZMAX.z=stress:-1]
  lip_friction: {friction}
"""


def wings(folder: Path) -> list[Check]:
    """Grow the wings by STEPS; compare K of each front and the corrected path with those in the plane."""
    folder.mkdir(parents=True, exist_ok=True)
    _write_main_crack(folder / "main.vtp")
    config = CONFIG.format(l0=1.25 * EDGE, edge=EDGE, step=STEP, friction=FRICTION)
    case = grown(folder, config, STEPS + 2, f"{STEPS:03d}/base.vtp")
    unit = np.sqrt(np.pi * HALF)
    first = _inner(columns(case, 0))
    slides = (1 - FRICTION) / 2 * unit
    checks = [
        Check("K_I of the main crack over K_II", float(np.abs(first["K_I"]).max() / slides), 0.0, 0.02),
        Check(
            "K_II of the main crack over the exact", float(np.abs(first["K_II"]).mean() / slides), 1.0, 0.01
        ),
        Check("|kink angle|, degrees", float(np.abs(first["kink_angle"]).mean()), MODE_II, 0.5),
    ]
    path = wing_cracks.wing_path(END, STRESS, FRICTION, STEP / HALF / 2, 2 * STEPS + 1)
    plane = np.stack([path.real, path.imag], axis=1)[:, None]
    for step in range(1, STEPS + 1):
        corners = [END, *(_mean(front(case, before)[:, [0, 2]]) for before in range(1, step))]
        rows = _inner(columns(case, step))
        tip = _mean(np.stack([rows["x"], rows["z"]], axis=1))
        known = wing_cracks.tip_k([*corners, tip], STRESS, FRICTION)[0] * np.sqrt(HALF)
        laid = _mean(front(case, step)[:, [0, 2]])
        off = distance_to_path(np.array([[laid.real, laid.imag]]), plane)[0]
        checks += [
            Check(
                f"K_I over that in the plane, step {step}", float(rows["K_I"].mean() / known), 1.0, MOST_K
            ),
            Check(f"off the path in the plane, half cracks, step {step}", float(off), 0.0, 0.02),
        ]
    return checks


def _inner(columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the columns at nodes off the plate's faces."""
    inner = (columns["y"] > EDGE / 2) & (columns["y"] < THICKNESS - EDGE / 2)
    return {name: values[inner] for name, values in columns.items()}


def _mean(places: np.ndarray) -> complex:
    """Return the mean of places (k, 2) along x and z over HALF, those of the lower wing turned."""
    x, z = (places - CENTRE).T / HALF * np.sign(places[:, 1] - CENTRE)
    return complex(x.mean(), z.mean())


def _write_main_crack(path: Path) -> None:
    """Write the main crack as two triangles, which end beyond the plate's faces."""
    from craftmesh.cracks.triangulated import crack_from_triangles
    from craftmesh.io.vtk import write_crack

    ways = HALF * np.array([-END, END])
    points = [(CENTRE + way.real, y, CENTRE + way.imag) for y in (-1.0, THICKNESS + 1) for way in ways]
    box = np.array([[0.0, 0.0, 0.0], [WIDTH, THICKNESS, WIDTH]])
    write_crack(path, crack_from_triangles(np.array(points), np.array([[0, 1, 3], [0, 3, 2]]), None, box))

"""A case of each kind of growing crack: shape, material, grains, voids and roughness by the seed."""

from dataclasses import replace

import numpy as np

from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.prescription import frame_along
from craftmesh.sizing.sizing import SizingOptions
from craftmesh.types import Voxels
from craftmesh.voxels.generate import GenerateOptions, generate
from trials.drawing import Drawn
from trials.sheets import Relief, Sheet, disc, draw_relief, placed, strip
from trials.volumes import MEASURED, crop

SHAPES = ("penny", "ellipse", "edge", "corner", "through")
COPPER, STEEL = "cubic:168400,121400,75400", "cubic:204600,137700,126200"
MATERIALS = {"isotropic": "isotropic:70000,0.3", "copper": COPPER, "measured": STEEL}
SIDES = (22, 29)  # voxels
SIZES = (0.16, 0.26)  # crack radius, depth or longer semi-axis in the smallest side of the box
STEEPEST = 45.0  # degrees between the crack and the section perpendicular to the load
STEPS = 24  # triangles of a rough sheet along its radius


def draw_kind(seed: int) -> Drawn:
    """Return the case of `seed`; 30 successive seeds have each shape in each material, plain and rough."""
    rng = np.random.default_rng(seed)
    group = seed // len(SHAPES)
    shape, material = SHAPES[seed % len(SHAPES)], list(MATERIALS)[group % len(MATERIALS)]
    rough, has_voids = bool(group % 2), material != "measured" and bool(group // 2 % 2)
    voxels = _volume(rng, material, has_voids)
    size = float(rng.uniform(*SIZES) * np.ptp(voxels.box, axis=0).min())
    l_min = size / rng.uniform(5.0, 6.0)
    centre, frame = _place(rng, voxels.box, shape)
    sheet, prescribed = _sheet(rng, shape, size, l_min if rough else 0.0)
    if prescribed is not None:
        three = {"centre": centre, "normal": frame[2], "axis": frame[0]}
        prescribed = replace(prescribed, **{key: tuple(value.tolist()) for key, value in three.items()})
    sheet = placed(sheet, centre, frame)
    kinds = {
        "volume": material + " with voids" * has_voids,
        "crack": shape,
        "relief": "rough" if rough else "plain",
    }
    sizes = SizingOptions(l_min=l_min, l0=1.2 * l_min, l_max=6 * l_min, r0=2 * l_min, r1=14 * l_min)
    return Drawn(seed, voxels, sheet, prescribed, True, sizes, "C3D4", False, kinds)


def _volume(rng: np.random.Generator, material: str, has_voids: bool) -> Voxels:
    """Return the grains: a window of a measured volume, or generated ones."""
    shape = rng.integers(SIDES[0], SIDES[1] + 1, 3)
    if material == "measured" and MEASURED["al6xn"].exists():
        return crop(rng, MEASURED["al6xn"], shape)
    voids = {"voids": int(rng.integers(1, 4)), "void_radius": 2.5} if has_voids else {}
    seed, grains = int(rng.integers(2**31)), int(rng.integers(6, 24))
    return generate(GenerateOptions(shape=tuple(shape.tolist()), grains=grains, seed=seed, **voids))


def _place(rng: np.random.Generator, box: np.ndarray, shape: str) -> tuple[np.ndarray, np.ndarray]:
    """Return a crack's centre (3,) and frame (3, 3): rows u, v, normal.

    An edge crack lies on the face x = 0, a corner crack on an edge of it. The normal of a through crack is
    perpendicular to its front.
    """
    centre = box[0] + rng.uniform(0.35, 0.65, 3) * np.ptp(box, axis=0)
    on_faces = {"edge": 1, "through": 1, "corner": 2}.get(shape, 0)
    centre[:on_faces] = box[0, :on_faces]
    tilt, turn = np.radians(rng.uniform(0, STEEPEST)), rng.uniform(0, 2 * np.pi)
    turn = 0.0 if shape == "through" else turn
    normal = np.array([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)])
    return centre, frame_along(normal, np.array([1.0, 0.0, 0.0]))


def _sheet(
    rng: np.random.Generator, shape: str, size: float, l_min: float
) -> tuple[Sheet, CrackOptions | None]:
    """Return a sheet in local coordinates, and the options that prescribe it if it is plain (l_min 0)."""
    relief = draw_relief(rng, "fractal", size, l_min) if l_min else Relief(lambda u, _: 0 * u)
    step = size / STEPS
    if shape == "through":
        sheet = strip(lambda _, v: size + 0 * v, 2 * size, 4 * size, relief, 4 * step)
        return sheet, None if l_min else CrackOptions(shape="through_edge", radius=size)
    ratio = 1.0 if shape == "penny" else float(rng.uniform(0.5, 0.95))
    sheet = disc((size, size * ratio), relief, step)
    if l_min:
        return sheet, None
    if shape == "penny":
        return sheet, CrackOptions(shape="penny", radius=size)
    return sheet, CrackOptions(shape="ellipse", semi_axes=(size, size * ratio))

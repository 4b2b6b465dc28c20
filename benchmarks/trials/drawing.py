"""A random case: a volume, a crack and sizes, small enough that its mesh has some 150,000 tetrahedra."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.cracks.options import CrackOptions
from craftmesh.sizing.sizing import Sizing, SizingOptions, densify
from craftmesh.types import Voxels
from trials import more_cracks
from trials.placing import draw_place
from trials.sheets import RELIEF_SHARES, RELIEFS, Sheet, disc, draw_relief, placed, strip, with_rim
from trials.volumes import draw_volume

MOST_TETS = 150_000
TETS_PER_LENGTH = 10.0  # tetrahedra of edge l in a volume l^3
RAISED = 1.1  # l_min and l0 grow by this until the mesh is small enough
FINEST = 60  # triangles from the middle of a sheet to its rim at most
COARSEST = 1.25  # steps of the sheet's triangles that its reliefs take for l_min at least
LARGEST_L_MIN = 4.0  # voxels: with MOST_TETS never reached in 48^3 voxels, it ends the raising


@dataclass(frozen=True)
class Drawn:
    """All of one case. `prescribed`: options of a planar shape, or of a crack along grain boundaries; else
    the sheet is given as it is. parts: the cracks of the sheet where it is several.
    """

    seed: int
    voxels: Voxels
    sheet: Sheet
    prescribed: CrackOptions | None
    with_front: bool
    sizes: SizingOptions
    element: str
    quarter_points: bool
    kinds: dict[str, str]
    parts: tuple[Sheet, ...] = ()

    @property
    def words(self) -> str:
        shape = "x".join(map(str, self.voxels.labels.shape))
        return ", ".join([f"{shape} {self.kinds['volume']}", *list(self.kinds.values())[1:]])


def draw(seed: int, sides: tuple[int, int] = (30, 48), kind: str | None = None) -> Drawn:
    """Return the case of `seed`; the same seed gives the same case.

    kind: of the crack, else drawn too.
    """
    case = _of_kind(seed, sides, kind)
    sheet = case.sheet if case.with_front or case.prescribed else with_rim(case.sheet, case.voxels.box)
    return replace(case, sheet=sheet)


def _of_kind(seed: int, sides: tuple[int, int], kind: str | None) -> Drawn:
    case = draw_one(seed, sides)
    rng = np.random.default_rng([seed, more_cracks.STREAM])
    kind = kind or more_cracks.draw_kind(rng)
    if kind == "one":
        return case
    l_min = float(case.sizes.l_min or 0)
    prescribed, parts = None, ()
    if kind == "boundaries":
        found = more_cracks.boundaries(rng, case.voxels)
        if found is None:
            return case
        sheet, prescribed = found
    elif kind == "pair":
        parts = more_cracks.pair(rng, case.voxels, case.sheet, l_min)
        sheet = more_cracks.together(parts)
    else:
        sheet = more_cracks.hook(rng, case.voxels, l_min)
    return replace(
        case,
        sheet=sheet,
        prescribed=prescribed,
        parts=parts,
        with_front=case.with_front and kind == "pair",
        sizes=_small_enough(case.voxels, sheet, case.sizes),
        kinds=case.kinds | {"crack": kind},
    )


def _small_enough(voxels: Voxels, sheet: Sheet, sizes: SizingOptions) -> SizingOptions:
    """Return sizes that give the mesh around a sheet no more than MOST_TETS."""
    longest = LARGEST_L_MIN * float(voxels.spacing.mean())
    while estimated_tets(voxels, sheet, sizes) > MOST_TETS and sizes.l_min <= longest:
        l_min, l0 = RAISED * sizes.l_min, RAISED * sizes.l0
        sizes = replace(sizes, l_min=l_min, l0=l0, l_max=max(sizes.l_max, l0))
    return sizes


def draw_one(seed: int, sides: tuple[int, int]) -> Drawn:
    """Return the case of `seed` with one crack, a height over a plane."""
    rng = np.random.default_rng(seed)
    voxels, volume = draw_volume(rng, sides)
    sizes = _sizes(rng, voxels)
    shape = str(rng.choice(["disc", "strip"], p=[0.68, 0.32]))
    relief = str(rng.choice(RELIEFS, p=RELIEF_SHARES))
    place, centre, frame = draw_place(rng, voxels, shape == "strip")
    element = str(rng.choice(["C3D4", "C3D10"]))
    quarter = element == "C3D10" and rng.random() < 0.3
    with_front = rng.random() < 0.5
    stream = int(rng.integers(2**31))
    least = float(np.ptp(voxels.box, axis=0).min())
    while True:
        width = _half_width(voxels.box, centre, frame[1])
        sheet, prescribed = _crack(
            np.random.default_rng(stream), (shape, relief), (least, width), sizes.l_min
        )
        sheet = placed(sheet, centre, frame)
        longest = LARGEST_L_MIN * float(voxels.spacing.mean())
        if estimated_tets(voxels, sheet, sizes) <= MOST_TETS or sizes.l_min > longest:
            break
        l_min, l0 = RAISED * sizes.l_min, RAISED * sizes.l0
        sizes = replace(sizes, l_min=l_min, l0=l0, l_max=max(sizes.l_max, l0))
    if prescribed is not None:
        prescribed = replace(
            prescribed, centre=_three(centre), normal=_three(frame[2]), axis=_three(frame[0])
        )
    kinds = {
        "volume": volume,
        "crack": prescribed.shape if prescribed else shape,
        "relief": relief,
        "place": place,
    }
    return Drawn(seed, voxels, sheet, prescribed, with_front, sizes, element, quarter, kinds)


def _sizes(rng: np.random.Generator, voxels: Voxels) -> SizingOptions:
    edge = float(np.cbrt(voxels.spacing.prod()))
    l_min = edge * np.exp(rng.uniform(np.log(0.3), np.log(1.5)))
    l_max = max(l_min, edge * np.exp(rng.uniform(np.log(1.2), np.log(15))))
    l0 = float(np.clip(edge * rng.uniform(0.8, 1.5), l_min, l_max))
    r0 = edge * rng.uniform(1, 10)
    return SizingOptions(
        l_min=float(l_min),
        l0=l0,
        l_max=float(l_max),
        r0=float(r0),
        r1=float(r0 + edge * rng.uniform(0.5, 20)),
        gradation=float(rng.uniform(1.25, 1.8)) if rng.random() < 0.2 else None,
    )


def _crack(
    rng: np.random.Generator, kind: tuple[str, str], room: tuple[float, float], l_min: float
) -> tuple[Sheet, CrackOptions | None]:
    """Return a sheet in local coordinates, and the options that prescribe it where it is flat.

    room: the least edge of the box, and half of the width that a strip takes to leave it on both sides.
    """
    shape, relief_kind = kind
    least, half_width = room
    size = float(rng.uniform(0.15, 0.5) * least)
    step = max(l_min * rng.uniform(0.3, 0.8), max(size, half_width) / FINEST)
    l_min = max(l_min, COARSEST * step)
    if shape == "disc":
        ratio = float(rng.choice([1.0, rng.uniform(0.4, 1.0)]))
        relief = draw_relief(rng, relief_kind, size * ratio, l_min)
        sheet = disc((size, size * ratio), relief, step)
        if relief_kind != "flat":
            return sheet, None
        if ratio == 1:
            return sheet, CrackOptions(shape="penny", radius=size)
        return sheet, CrackOptions(shape="ellipse", semi_axes=(size, size * ratio))
    relief = draw_relief(rng, relief_kind, size, l_min)
    bend = float(rng.choice([0.0, rng.uniform(0, 0.2)])) * size
    wave = 2 * np.pi / (least * rng.uniform(0.5, 2))
    sheet = strip(lambda _, v: size + bend * np.sin(wave * v), 0.5 * least, half_width, relief, step)
    straight = relief_kind == "flat" and bend == 0
    return sheet, CrackOptions(shape="through_edge", radius=size) if straight else None


def _half_width(box: np.ndarray, centre: np.ndarray, across: np.ndarray) -> float:
    """Return how far a sheet at `centre` reaches along the vector `across` until it is out of the box."""
    corners = np.stack(np.meshgrid(*box.T, indexing="ij"), axis=-1).reshape(-1, 3)
    return 1.05 * float(np.abs((corners - centre) @ across).max())


def _three(vector: np.ndarray) -> tuple[float, float, float]:
    x, y, z = vector.tolist()
    return x, y, z


def estimated_tets(voxels: Voxels, sheet: Sheet, sizes: SizingOptions) -> float:
    """Return the number of tetrahedra that the sizes ask for: the integral of TETS_PER_LENGTH / l^3."""
    l_min, l0, l_max, r0, r1 = (float(getattr(sizes, k) or 0) for k in ("l_min", "l0", "l_max", "r0", "r1"))
    plain = Sizing(l_min, l0, l_max, r0, r1, 1.0, np.zeros((1, 3)), sizes.growth)
    rng = np.random.default_rng(0)
    places = np.argwhere(voxels.labels > 0)
    parts = 1 + 60_000 // len(places)
    inside = (np.tile(places, (parts, 1)) + rng.random((parts * len(places), 3))) * voxels.spacing
    dense = np.concatenate([densify(front, l_min) for front in sheet.fronts])
    near = ((dense >= voxels.box[0] - r1) & (dense <= voxels.box[1] + r1)).all(axis=1)
    within = ((dense >= voxels.box[0]) & (dense <= voxels.box[1])).all(axis=1)
    if not within.any():
        return 0.0
    distance = cKDTree(dense[near & within]).query(voxels.origin + inside)[0]
    lengths = plain.at_distance(distance)
    return float(TETS_PER_LENGTH * (voxels.spacing.prod() / parts) * (1 / lengths**3).sum())

"""K along crack fronts by the whole chain, voxels to sif.csv, against exact answers.

The outer faces get the displacements of an infinite body: uniform strain, then once more with those of the
opening that was found, so that the box's size does not count. A second table holds the error that sif.csv
claims against the true one; it ends with 1 where that is true in less than 95 % of the nodes.
"""

import argparse
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import claims
import exact_cracks
import neighbours
import numpy as np
from exact_cracks import COPPER, POISSON, YOUNG
from measure import ChildFailed, in_child, print_table, write_json
from opened import opened_mesh

EDGE, CENTRE, RADIUS = 60, np.array([30.2, 29.8, 30.1]), 6.0
TENSION = np.diag([0.0, 0, 1])
SHEAR = np.array([[0.0, 0, 1], [0, 0, 0], [1, 0, 0]])
MIXED = np.array([[0, 0, 0.7], [0, 0, 0.3], [0.7, 0.3, 0.5]])
# Residuals of the first solution, whose opening corrects K of a penny by 0.6 %, of the first solution with
# friction, and of the second solution.
ROUGH, SLIDING, FINE = 1e-3, 1e-5, 1e-7
TABLE = RADIUS / 60  # distance of the places at which a table gives tractions on lips
WARM = RADIUS / 24  # distance of the points of a table of temperatures
CAP = RADIUS / 20  # edges of the cap's triangles
INCLUSION, HEAT = 6.0, 1e-3  # radius and eigenstrain of the hot inclusion
KINK = 40.0  # degrees, of the last third of the strip
_TURN = np.radians(KINK)
_KINKED = (
    (-1.0, 20.1),
    (2 * RADIUS / 3, 20.1),
    (RADIUS / 3 * (2 + np.cos(_TURN)), 20.1 + RADIUS / 3 * np.sin(_TURN)),
)
EDGE_DEPTH = 2.0  # small in the body: K differs by 0.1 % from that in a half space
APART, BELOW, NEAR = 2.5, 0.5, 1.5  # middle to middle of two pennies, and to a face, over their radii
SMALL = 3.0  # radius of the penny below a face, whose box is to be as large as a half space
END = 2.0  # of the coarse edges: nodes this near to an end of a front count apart, as `ends`
ALUMINIUM = (107.3e3, 60.8e3, 28.3e3)
ZENER_8 = (149.6e3, 130.8e3, 75.4e3)  # of nearly the copper crystal's mean stiffness
TURN = (0.8, 0.3, -0.4, 0.33)  # of the crystal, a general one
COLUMNS = {
    "case": "case",
    "load": "load",
    "edges": "a/h",
    "tets": "tets",
    "K_I": "K_I mean/rms/max %",
    "K_II": "K_II mean/rms/max %",
    "K_III": "K_III mean/rms/max %",
    "ends": "K_I at ends %",
    "printed": "ratios off printed %",
    "kink": "kink max deg",
    "root": "root J/G - 1 %",
    "spread": "spread max %",
    "solve_s": "solve s",
    "fracture_s": "K s",
}


@dataclass(frozen=True)
class Case:
    """A crack, its loads by name, exact(stress, tensor): K as a function of points and frames.

    material: "isotropic", "crystal", a cubic one of these constants, or "polycrystal" of it; cap: the
    crack is a cap of a sphere; pulled: by a stress on planes of the box, whose other planes are free;
    grains: their number; layered: two grains, their boundary amid the box across that axis; stiffer:
    the second's modulus over the first's; beside: another crack; path: x and z of the points of a crack
    through the box along y; halved: errors are those against edges half as long; closed: the lips press
    on each other, with this coefficient of friction; pressed: the stress across the crack acts on its lips,
    and none far away; by_place: so does the one of exact_cracks.LIP_LOADS that the load names, from a
    table; residual: from a table of residual stress; field: a PointField, from which they come; grown:
    edges grow as fast as they may from the front on; hot: the middle of an inclusion, grain 2, whose
    eigenstrain is HEAT along all axes; nothing else loads the body then; warm: the temperature of one of
    `exact_cracks.warmed`, times HEAT.
    """

    crack: dict
    loads: dict
    exact: Callable | None = None
    size: float = RADIUS
    material: str = "isotropic"
    poisson: float = POISSON
    constants: tuple[float, float, float] = COPPER
    cap: bool = False
    pulled: bool = False
    voxels: tuple[int, int, int] = (EDGE, EDGE, EDGE)
    printed: tuple[tuple[float, ...], tuple[float, ...]] | None = None
    grains: int = 8
    layered: int | None = None
    stiffer: float = 1.0
    beside: dict | None = None
    path: tuple[tuple[float, float], ...] | None = None
    halved: bool = False
    closed: bool = False
    friction: float = 0.0
    pressed: bool = False
    by_place: bool = False
    residual: bool = False
    field: object = None
    grown: bool = False
    hot: tuple[float, float, float] | None = None
    warm: str = ""


def _normal(degrees: float) -> tuple:
    return (float(np.sin(np.radians(degrees))), 0.0, float(np.cos(np.radians(degrees))))


def _penny(degrees: float, loads: dict, poisson: float = POISSON) -> Case:
    normal = np.array(_normal(degrees))
    crack = {"shape": "penny", "centre": tuple(CENTRE), "radius": RADIUS, "normal": tuple(normal)}
    return Case(
        crack, loads, lambda stress, _: exact_cracks.penny(RADIUS, normal, stress, poisson), poisson=poisson
    )


def _closed(degrees: float, friction: float = 0.0) -> Case:
    """A penny under pressure: its lips pass on the stress across them, and slide if friction lets them."""
    open_penny = _penny(degrees, {"pressure": -TENSION})
    slides = max(1 - friction / np.tan(np.radians(degrees)), 0.0)

    def exact(stress, tensor):
        k_of = open_penny.exact(stress, tensor)
        return lambda *frames: k_of(*frames) * [0, slides, slides]

    return replace(open_penny, exact=exact, closed=True, friction=friction)


def _by_place(grown: bool) -> Case:
    """A penny whose lips bear each of the loads that vary over them."""

    def exact(stress, _):
        return exact_cracks.loaded_penny(RADIUS, CENTRE, stress)

    return replace(
        _penny(0, {name: name for name in exact_cracks.LIP_LOADS}), exact=exact, by_place=True, grown=grown
    )


def _edge() -> Case:
    """An edge crack under residual stresses uniform along y; its body is held as half of a plate."""

    def exact(load, _):
        return exact_cracks.loaded_edge(EDGE_DEPTH, load)

    return Case(
        {"shape": "surface"},
        {name: name for name in exact_cracks.EDGE_LOADS},
        exact,
        size=EDGE_DEPTH,
        poisson=0.0,
        residual=True,
        pulled=True,
        voxels=(80, 2, 120),
        path=((-1.0, 60.1), (EDGE_DEPTH, 60.1)),
    )


def _two_pennies() -> Case:
    """Two pennies in one plane, half a radius between their fronts."""
    away = np.array([APART * RADIUS / 2, 0, 0])
    one = _penny(0, {"tension": TENSION})
    cracks = [one.crack | {"centre": tuple(CENTRE + side * away)} for side in (-1, 1)]
    return replace(
        one,
        crack=cracks[0],
        beside=cracks[1],
        exact=lambda *_: neighbours.two_pennies(RADIUS, CENTRE, APART),
    )


def _below_face() -> Case:
    """A penny under pressure, parallel to the box's upper face and half a radius below it."""
    middle = (CENTRE[0], CENTRE[1], EDGE - BELOW * SMALL)
    crack = {"shape": "penny", "centre": middle, "radius": SMALL}
    return Case(
        crack,
        {"pressure": TENSION},
        lambda *_: neighbours.penny_below_face(SMALL, middle, BELOW),
        size=SMALL,
        pressed=True,
        pulled=True,
    )


def _near_face() -> Case:
    """A crack through a plate, square to the face x = 0 and a quarter of its length away from it."""
    ends = ((NEAR - 1) * EDGE_DEPTH, (NEAR + 1) * EDGE_DEPTH)
    return replace(
        _edge(),
        loads={"pressure": TENSION},
        exact=lambda *_: neighbours.crack_square_to_face(EDGE_DEPTH, NEAR),
        residual=False,
        pressed=True,
        path=tuple((x, 60.1) for x in ends),
    )


def _heated(height: float) -> Case:
    """A penny beside a hot ball of radius INCLUSION whose middle is that far over its plane."""
    hot = tuple((CENTRE + [RADIUS + INCLUSION + 1.5, 0.0, height]).tolist())
    return replace(_penny(0, {"heat": 0 * TENSION}), exact=None, hot=hot)


def _warmed(kind: str, stress) -> Case:
    """A penny in a body of a temperature that varies, in a stress far away."""

    def exact(stress, _):
        return exact_cracks.warmed_penny(kind, RADIUS, CENTRE, stress, HEAT)

    return replace(_penny(0, {"heat": stress}), exact=exact, warm=kind)


def _ellipse(a: float, b: float) -> Case:
    crack = {"shape": "ellipse", "centre": tuple(CENTRE), "semi_axes": (a, b)}
    return Case(crack, {"tension": TENSION}, lambda *_: exact_cracks.ellipse(a, b, CENTRE, 1.0), size=b)


def _in_boundary(case: Case) -> Case:
    """The flat penny of a case, moved into the boundary of two layers."""
    middle = (CENTRE[0], CENTRE[1], EDGE / 2)
    return replace(case, crack=case.crack | {"centre": middle}, layered=2)


def _halved(case: Case, centre=CENTRE, radius: float = RADIUS, **other) -> Case:
    """The penny of a case without an exact answer, at another place, against edges half as long."""
    crack = case.crack | {"centre": tuple(centre), "radius": radius}
    return replace(case, crack=crack, size=radius, exact=None, pulled=True, halved=True, **other)


def _sixty_grains(constants: tuple[float, float, float] = COPPER) -> Case:
    penny = _penny(22, {"tension": TENSION})
    body = {"material": "polycrystal", "grains": 60, "voxels": (40, 40, 40), "constants": constants}
    return _halved(penny, (20.2, 19.8, 20.1), 8.0, **body)


def _crystal(constants: tuple[float, float, float] = COPPER) -> Case:
    flat = _penny(0, {"tension": TENSION, "mixed": MIXED})
    normal = np.array([0.0, 0, 1])
    return replace(
        flat,
        material="crystal",
        constants=constants,
        exact=lambda stress, c: exact_cracks.crystal_penny(c, RADIUS, normal, stress),
    )


def _by_formula(crack: dict, k1_at: Callable, **other) -> Case:
    """A crack pulled by a stress on planes of the box; k1_at(points): K_I by a formula, in pure mode I."""

    def k_of(points, *_frames):
        k = k1_at(points)
        return np.column_stack([k, 0 * k, 0 * k])

    return Case(crack, {"tension": TENSION}, lambda *_: k_of, pulled=True, **other)


def _semicircle() -> Case:
    crack = {"shape": "penny", "centre": (CENTRE[0], 0.0, CENTRE[2]), "radius": RADIUS}

    def k1_at(points):
        angle = np.arctan2(points[:, 1], np.abs(points[:, 0] - CENTRE[0]))
        return exact_cracks.newman_raju(angle, RADIUS, EDGE, EDGE / 2)

    return _by_formula(crack, k1_at)


def _quarter_ellipse(thickness: int) -> Case:
    """A corner crack with semi-axes RADIUS and half of it, the latter through a plate's thickness."""
    voxels = (36, thickness, 40)
    centre = (0.0, 0.0, voxels[2] / 2 + 0.1)
    crack = {"shape": "ellipse", "centre": centre, "semi_axes": (RADIUS, RADIUS / 2)}

    def k1_at(points):
        angle = np.arctan2(points[:, 1] / (RADIUS / 2), points[:, 0] / RADIUS)
        return exact_cracks.newman_raju_corner(angle, RADIUS / 2, RADIUS, thickness)

    return _by_formula(crack, k1_at, size=RADIUS / 2, voxels=voxels)


def _half_ellipse(depth: float, voxels: tuple[int, int, int], angles: tuple, k1: tuple) -> Case:
    """A surface crack of half width RADIUS in the middle of a plate's face y = 0, pulled along z."""
    centre = (voxels[0] / 2 + 0.2, 0.0, voxels[2] / 2 + 0.1)
    crack = {"shape": "ellipse", "centre": centre, "semi_axes": (RADIUS, depth)}
    return Case(crack, {"tension": TENSION}, pulled=True, voxels=voxels, printed=(angles, k1))


CASES = {
    "penny": _penny(0, {"tension": TENSION, "shear": SHEAR}),
    "inclined 30": _penny(30, {"tension": TENSION}),
    "inclined 45": _penny(45, {"tension": TENSION}),
    "inclined 60": _penny(60, {"tension": TENSION}),
    "inclined 45, Poisson's ratio 0.49": _penny(45, {"tension": TENSION}, 0.49),
    "pressed": replace(_penny(0, {"pressure": TENSION}), pressed=True),
    "by place": _by_place(grown=False),
    "by place, grown": _by_place(grown=True),
    "residual": replace(_by_place(grown=False), residual=True),
    "residual, edge": _edge(),
    "heated": _heated(0.0),
    "heated, halved": replace(_heated(1.5), halved=True),
    "temperature, linear": _warmed(exact_cracks.LINEAR, YOUNG * HEAT * TENSION),
    "temperature, parabola": _warmed(exact_cracks.PARABOLA, 0 * TENSION),
    "temperature, spot": _warmed(exact_cracks.SPOT, 0 * TENSION),
    "closed 30": _closed(30),
    "closed 45": _closed(45),
    "closed 60": _closed(60),
    "friction 0.3": _closed(45, 0.3),
    "friction 0.6": _closed(45, 0.6),
    "ellipse 2:1": _ellipse(8.0, 4.0),
    "ellipse 25:6": _ellipse(12.5, 3.0),
    "crystal": _crystal(),
    "crystal, Zener 8": _crystal(ZENER_8),
    "lens": Case(
        {"shape": "surface"},
        {"hydrostatic": np.eye(3)},
        lambda *_: exact_cracks.lens(RADIUS),
        poisson=exact_cracks.LENS_POISSON,
        cap=True,
    ),
    "semicircle": _semicircle(),
    # a/c, a/t and c/b are 0.9, 0.6 and 0.3; 1.25, 0.7 and 0.4 (a/t 0.68, c/b 0.4 in whole voxels)
    "half ellipse 0.9": _half_ellipse(
        5.4,
        (40, 9, 48),
        (0.104720, 0.127808, 0.150895, 0.173983, 0.197071),
        (40.3077, 39.9333, 39.5811, 39.2523, 38.9427),
    ),
    "half ellipse 1.25": _half_ellipse(
        7.5,
        (30, 11, 48),
        (2.944522, 2.967609, 2.990697, 3.013785, 3.036873),
        (42.0497, 42.4776, 42.9209, 43.3793, 43.8488),
    ),
    "quarter ellipse": _quarter_ellipse(6),
    "quarter ellipse, halved": replace(_quarter_ellipse(6), exact=None, halved=True),
    "quarter ellipse, thick": _quarter_ellipse(15),
    "boundary": _in_boundary(_penny(0, {"tension": TENSION, "shear": SHEAR})),
    "boundary, crystal": _in_boundary(_crystal()),
    "boundary, two crystals": replace(
        _in_boundary(_penny(0, {"tension": TENSION})), exact=None, material="polycrystal", pulled=True
    ),
    "polycrystal, halved": replace(
        _penny(45, {"tension": TENSION}), exact=None, material="polycrystal", pulled=True, halved=True
    ),
    "60 grains, halved": _sixty_grains(),
    "60 grains of aluminium, halved": _sixty_grains(constants=ALUMINIUM),
    "two materials, halved": _halved(
        _penny(0, {"tension": TENSION}), CENTRE - [0, 0, 2.1], layered=2, stiffer=3.0
    ),
    "two materials, crossed, halved": _halved(_penny(30, {"tension": TENSION}), layered=0, stiffer=3.0),
    "two pennies, halved": _halved(
        _penny(0, {"tension": TENSION}),
        CENTRE - [2.0, 0, 1.4],
        beside=_penny(0, {}).crack | {"centre": tuple(CENTRE + [2.0, 0, 1.4])},
    ),
    "two pennies": _two_pennies(),
    "below a face": _below_face(),
    "near a face": _near_face(),
    "semicircle, halved": replace(_semicircle(), exact=None, halved=True),
    "lens, halved": Case({"shape": "surface"}, {"tension": TENSION}, cap=True, pulled=True, halved=True),
    "kinked strip, halved": Case(
        {"shape": "surface"},
        {"tension": TENSION},
        path=_KINKED,
        pulled=True,
        voxels=(40, 24, 40),
        halved=True,
    ),
}


def meshed(case: Case, length: float):
    """Return the mesh of a cube of 8 grains or 2 layers, the crack opened, its front's edges `length`."""
    from craftmesh.cracks.options import CrackOptions
    from craftmesh.cracks.series import GivenSurface, crack_of_increment
    from craftmesh.cracks.sheets import one_crack
    from craftmesh.sizing.sizing import SizingOptions
    from craftmesh.types import Voxels
    from craftmesh.voxels.generate import GenerateOptions, generate

    voxels = generate(GenerateOptions(shape=case.voxels, grains=case.grains, seed=1))
    if case.layered is not None:
        labels = 1 + (np.indices(case.voxels)[case.layered] >= case.voxels[case.layered] // 2)
        voxels = Voxels(labels.astype(np.int32), voxels.spacing, voxels.origin)
    if case.hot:
        off = np.moveaxis(np.indices(case.voxels), 0, -1) + 0.5 - case.hot
        labels = 1 + (np.linalg.norm(off, axis=-1) < INCLUSION)
        voxels = Voxels(labels.astype(np.int32), voxels.spacing, voxels.origin)
    given = GivenSurface(*_cap()) if case.cap else GivenSurface(*_strip(case)) if case.path else None
    crack = crack_of_increment(CrackOptions(**case.crack), 0, voxels.box, given)
    if case.beside:
        crack = one_crack([crack, crack_of_increment(CrackOptions(**case.beside), 0, voxels.box, None)])
    near, far = (1.25 * length, RADIUS + 2.0) if case.grown else (min(6.0, 2 * case.size), 20.0)
    sizes = SizingOptions(l_min=length, l0=max(1.0, 1.25 * length), l_max=6.0, r0=near, r1=far)
    return opened_mesh(voxels, crack, sizes)


def _cap():
    """Return points and triangles of a cap of 45 degrees of a sphere, its rim at RADIUS round CENTRE.

    They are the same for all meshes, so that facets of two sizes are not two cracks.
    """
    from scipy.spatial import Delaunay

    sphere, tilt = RADIUS * np.sqrt(2), np.pi / 4
    rings = int(np.ceil(sphere * tilt / CAP))
    flat = [np.zeros((1, 2))]
    for ring in range(1, rings + 1):
        turn = np.linspace(0, 2 * np.pi, 6 * ring, endpoint=False)
        flat.append(ring * tilt / rings * np.column_stack([np.cos(turn), np.sin(turn)]))
    uv = np.concatenate(flat)
    angle = np.linalg.norm(uv, axis=1)
    along = uv * (np.sin(angle) / np.where(angle > 0, angle, 1))[:, None]
    points = sphere * np.column_stack([along, np.cos(angle) - np.cos(tilt)]) + CENTRE
    triangles = Delaunay(uv).simplices
    return points, triangles


def _strip(case: Case):
    """Return points and triangles of the crack of a case with a path: a strip through the box along y."""
    ends = (-1.0, case.voxels[1] + 1.0)
    points = np.array([[x, y, z] for y in ends for x, z in case.path])
    count = len(case.path)
    rows = np.arange(count - 1)
    near, far = rows + 1, rows + 1 + count
    return points, np.concatenate([np.stack([rows, near, far], 1), np.stack([rows, far, far - 1], 1)])


def model_of(mesh, case: Case):
    """Return the model of a mesh, quarter points at the front, without a load or with a hot inclusion."""
    crystal = case.material != "isotropic"
    from craftmesh.mechanics.model import elastic_model
    from craftmesh.mechanics.model_options import ModelOptions
    from craftmesh.mechanics.orientation import normalized, random_orientations

    material = (
        f"cubic:{','.join(map(repr, case.constants))}"
        if crystal
        else f"isotropic:{YOUNG!r},{case.poisson!r}"
    )
    strain = (f"{'2=' if case.hot else ''}isotropic:{HEAT!r}",) if case.hot or case.warm else ()
    materials = (material,)
    if case.stiffer != 1:
        materials = (f"1={material}", f"2=isotropic:{case.stiffer * YOUNG!r},{case.poisson!r}")
    options = ModelOptions(material=materials, load="none", quarter_points=True, eigenstrain=strain)
    count = int(mesh.grain.max()) + 1
    turns = np.tile(normalized(np.array(TURN)), (count, 1))
    if case.material == "polycrystal":
        turns = random_orientations(count, np.random.default_rng(5))
    phases = np.arange(count) if case.hot or case.stiffer != 1 else None
    model, _ = elastic_model(mesh, options, turns if crystal else None, phases)
    return replace(model, temperature=temperature_of(case, model.mesh.points)) if case.warm else model


def temperature_of(case: Case, points):
    """Return the temperature (n,) at points (n, 3): the parabola from a table of x and y, others exact."""
    from craftmesh.mechanics.point_fields import PointField

    if case.warm != exact_cracks.PARABOLA:
        return exact_cracks.warmed(case.warm, points - CENTRE, RADIUS, HEAT)[0]
    places = np.mgrid[0 : EDGE + WARM : WARM, 0 : EDGE + WARM : WARM].reshape(2, -1).T
    offset = np.column_stack([places, 0 * places[:, 0]]) - CENTRE
    values = exact_cracks.warmed(case.warm, offset, RADIUS, HEAT)[0]
    box = np.array([[0, 0, 0], case.voxels])
    return PointField(places, (0, 1), values[:, None]).at(points, "temperature", box, "everywhere")[:, 0]


def solved(case: Case, model, stress, tensor):
    """Return the field in an infinite body, under a stress far away or what the case has in its place."""
    from craftmesh.mechanics.load import Fixed, Load
    from craftmesh.solve.solve import SolveOptions, solve

    mesh = model.mesh
    pulled = on_lips(case, mesh, stress)
    heat = 0.0 if model.load is None else model.load.heat
    outer = np.unique(
        np.concatenate([mesh.node_sets[f"{axis}{end}"] for axis in "XYZ" for end in ("MIN", "MAX")])
    )
    uniform = mesh.points[outer] @ _strain(tensor, np.zeros((3, 3)) if pulled else stress)
    if case.hot:
        uniform += exact_cracks.round_inclusion(mesh.points[outer], *ball(mesh), HEAT)
    if case.warm:
        uniform += exact_cracks.warmed(case.warm, mesh.points[outer] - CENTRE, RADIUS, HEAT)[1]
    moved = uniform
    # ROUGH does not find all lips that touch
    for tolerance in (SLIDING if case.friction else ROUGH, FINE):
        held = tuple(Fixed(outer, axis, moved[:, axis]) for axis in range(3))
        options = SolveOptions(tolerance=tolerance, contact=case.closed)
        load = Load(held, (), pulled, heat)
        solution, _ = solve(replace(model, load=load, lip_friction=case.friction), options)
        if tolerance != FINE:
            places, jumps, normals = openings(mesh, solution.displacement)
            far = exact_cracks.displacements_of_opening(mesh.points[outer], places, jumps, normals, tensor)
            moved = uniform + far
    return solution


def on_lips(case: Case, mesh, load) -> tuple:
    """Return the tractions that a load of a case puts on the lips."""
    from craftmesh.mechanics.lips import LipField, loaded_lips
    from craftmesh.mechanics.point_fields import PointField
    from craftmesh.mechanics.residual_stress import residual_lips

    if case.field:
        return residual_lips(mesh, case.field)
    if case.pressed:
        return loaded_lips(mesh, load[2, 2])
    if case.path and case.residual:
        x = np.linspace(0, 2 * EDGE_DEPTH, 121)
        stress = np.outer(exact_cracks.EDGE_LOADS[load][0](x / EDGE_DEPTH), [0, 0, 1, 0, 0, 0])
        return residual_lips(mesh, PointField(x[:, None], (0,), stress))
    if not case.by_place:
        return ()
    places = np.arange(-RADIUS, RADIUS + TABLE / 2, TABLE)
    x, y = (part.ravel() for part in np.meshgrid(places, places))
    x, y = (part[np.hypot(x, y) <= RADIUS * (1 + 1e-9)] for part in (x, y))
    values = exact_cracks.LIP_LOADS[load](x / RADIUS, y / RADIUS)
    pressure, *pull = (np.broadcast_to(part, x.shape) for part in (*values, 0.0))
    places = np.column_stack([x, y, 0 * x]) + CENTRE
    if case.residual:  # lips A, above the crack, bear szz, sxz and syz
        stress = np.column_stack([0 * x, 0 * x, pressure, 0 * x, *pull[:2]])
        return residual_lips(mesh, PointField(places[:, :2], (0, 1), stress))
    return loaded_lips(mesh, 0.0, (), LipField(places, pressure, np.column_stack(pull)))


def ball(mesh):
    """Return the middle and the radius of a ball where grain 2 is and as large."""
    from craftmesh.mesh.tet_connectivity import tet_volumes

    tets = mesh.tets[mesh.grain == 2, :4]
    volume = tet_volumes(mesh.points, tets)
    middle = np.average(mesh.points[tets].mean(axis=1), axis=0, weights=volume)
    return middle, float(np.cbrt(0.75 * volume.sum() / np.pi))


def pulled(model, lips=()):
    """Return the field under unit stress along z on the box's planes, its own load, or tractions on lips.

    With tractions on the lips the planes XMAX, YMIN and ZMIN are held along their normals.
    """
    from craftmesh.mechanics.faces import parse_faces
    from craftmesh.mechanics.load import load_on, tension
    from craftmesh.solve.solve import SolveOptions, solve

    if lips:
        rows = parse_faces(("XMAX.x=fixed", "YMIN.y=fixed", "ZMIN.z=fixed"))
        model = replace(model, load=load_on(model.mesh, rows, lips=lips))
    load = model.load or tension(model.mesh, 2, 1.0, by_stress=True, rollers=False)
    return solve(replace(model, load=load), SolveOptions(tolerance=FINE))[0]


def _strain(tensor, stress):
    """Return the strain (3, 3) of a stress (3, 3)."""
    strain = np.linalg.lstsq(tensor.reshape(9, 9), np.asarray(stress, float).ravel(), rcond=1e-10)[0]
    return strain.reshape(3, 3)


def openings(mesh, displacement):
    """Return centres, jumps times area and unit normals (f, 3) of all lips A's facets, from lips B on."""
    from craftmesh.mesh.integration import triangle_points
    from craftmesh.mesh.mesh_sets import lip_faces
    from craftmesh.mesh.tet_connectivity import face_nodes

    nodes, opposite = (face_nodes(mesh.tets, faces) for faces in lip_faces(mesh.face_sets))
    other = _partners(mesh, np.unique(nodes), np.unique(opposite))
    jump = displacement[nodes] - displacement[other[nodes]]
    points = mesh.points[nodes]
    total, vector = np.zeros((len(nodes), 3)), np.zeros((len(nodes), 3))
    for at, weight in zip(*triangle_points()):
        value, slope = _six_nodes(at)
        first, second = (np.einsum("n,fni->fi", slope[:, k], points) for k in range(2))
        area = np.cross(first, second) * weight
        vector += area
        total += np.linalg.norm(area, axis=1)[:, None] * np.einsum("n,fni->fi", value, jump)
    # faces by the right-hand rule point into their elements: into lip A's, away from lip B
    normals = vector / np.linalg.norm(vector, axis=1, keepdims=True)
    return points[:, :3].mean(axis=1), total, normals


def _partners(mesh, a, b):
    """Return for each node of lips A (a,) the node of lips B (b,) in the same place, else itself (n,)."""
    only_a, only_b = np.setdiff1d(a, b), np.setdiff1d(b, a)
    other = np.arange(len(mesh.points))
    order = [only[np.lexsort(mesh.points[only].T)] for only in (only_a, only_b)]
    assert (mesh.points[order[0]] == mesh.points[order[1]]).all()
    other[order[0]] = order[1]
    return other


def _six_nodes(at):
    """Return the shape functions (6,) and slopes (6, 2) of a triangle with mid nodes 12, 23, 31."""
    share = np.array([1 - at[0] - at[1], *at])
    slope = np.array([[-1.0, -1], [1, 0], [0, 1]])
    ahead = [1, 2, 0]
    value = np.concatenate([share * (2 * share - 1), 4 * share * share[ahead]])
    mids = 4 * (share[:, None] * slope[ahead] + share[ahead][:, None] * slope)
    return value, np.vstack([(4 * share - 1)[:, None] * slope, mids])


def run(name: str, edges: float) -> list[dict]:
    """Return a row for each load of a case with edges of 1 / edges of its size."""
    from craftmesh.fracture.parameters import fracture_parameters
    from craftmesh.mechanics.near_field import as_tensor

    case = CASES[name]
    if case.halved:
        return halved(name, edges)
    mesh = meshed(case, case.size / edges)
    model = model_of(mesh, case)
    tensor = as_tensor(model.stiffness()[:1])[0]
    rows = []
    for load, stress in case.loads.items():
        start = time.process_time()
        lips = on_lips(case, model.mesh, stress)
        solution = pulled(model, lips) if case.pulled else solved(case, model, stress, tensor)
        middle = time.process_time()
        stiffness, contact = model.stiffness(), solution.contact
        found, _ = fracture_parameters(
            model.mesh, solution.displacement, model.grains, stiffness,
            contact=contact, lips=lips, eigenstrain=model.eigenstrain(), temperature=model.temperature,
        )  # fmt: skip
        exact = case.exact and case.exact(stress, tensor)
        if case.hot:
            exact = exact_cracks.heated(RADIUS, CENTRE, *ball(model.mesh), HEAT)
        figures = errors(
            model.mesh, found, exact, by_formula=case.pulled and not case.pressed and not case.path
        )
        if case.printed:
            figures["printed"] = off_printed(found, case)
        seconds = {"solve_s": middle - start, "fracture_s": time.process_time() - middle}
        rows.append(
            {"case": name, "load": load, "edges": edges, "tets": len(mesh.tets)} | figures | seconds
        )
    return rows


def halved(name: str, edges: float) -> list[dict]:
    """Return a row of how far K is off that with edges half as long, at the coarse front's nodes."""
    from craftmesh.cracks.polyline import feet, polyline
    from craftmesh.fracture.parameters import fracture_parameters
    from craftmesh.mesh.front_frames import front_frames

    case, fronts = CASES[name], []
    start = time.process_time()
    for cut in (1, 2):
        model = model_of(meshed(case, case.size / edges / cut), case)
        moved, strain = pulled(model).displacement, model.eigenstrain()
        found, _ = fracture_parameters(
            model.mesh, moved, model.grains, model.stiffness(), eigenstrain=strain
        )
        fronts.append((found, len(model.mesh.tets)))
    (coarse, tets), (fine, _) = fronts
    k, finer, closed = (
        _intensities(coarse),
        _intensities(fine),
        front_frames(model.mesh).closed.astype(bool),
    )
    wanted, inner, least = np.zeros_like(k), np.ones(len(k), bool), np.full(len(k), np.inf)
    for number in np.unique(fine.front):
        own = np.flatnonzero(fine.front == number)
        ring = np.append(own, own[:1]) if closed[own[0]] else own
        line = polyline(fine.points[ring])
        s, off = feet(line, coarse.points)
        here, least = off < least, np.minimum(off, least)
        wanted[here] = np.column_stack([np.interp(s, line.arc, one) for one in finer[ring].T])[here]
        near = np.minimum(s, line.length - s) < END * case.size / edges
        inner[here] = ~near[here] | closed[own[0]]
    largest = np.abs(wanted[inner]).max()
    row = {"case": name, "load": next(iter(case.loads)), "edges": edges, "tets": tets}
    row |= _modes(100 * (k - wanted)[inner] / largest) | claims.compared(k, wanted, coarse.error)
    if not inner.all():
        row["ends"] = float(100 * np.abs(k - wanted)[~inner].max() / largest)
    row["kink"] = _kink_error(k[inner], wanted[inner])
    return [row | {"solve_s": time.process_time() - start}]


def errors(mesh, found, exact: Callable | None, by_formula: bool) -> dict:
    """Return mean, rms and largest errors over all front nodes, in % of the largest exact K.

    Against a formula, nodes within 10 degrees of the surface count apart, as `ends`.
    """
    from craftmesh.mesh.front_frames import front_frames

    frames = front_frames(mesh)
    k = _intensities(found)
    wanted = exact(frames.points, frames.tangent, frames.binormal) if exact else k
    largest = np.abs(wanted).max()
    row = {
        "root": 100 * np.median(np.sqrt(np.maximum(found.J, 0) / found.G) - 1),
        "spread": 100 * found.spread.max() / largest,
    }
    if exact:
        off = 100 * (k - wanted) / largest
        inner = (
            frames.points[:, 1] > RADIUS * np.sin(np.radians(10)) if by_formula else np.ones(len(k), bool)
        )
        row |= _modes(off[inner])
        if by_formula:
            row["ends"] = np.abs(off[~inner, 0]).max()
        else:  # those of the formula for a semicircle are within 5 %
            row |= claims.compared(k, wanted, found.error)
        row["kink"] = _kink_error(k, wanted)
    return {key: float(value) if isinstance(value, np.floating) else value for key, value in row.items()}


def _intensities(found):
    """Return K_I, K_II, K_III (n, 3) of the nodes."""
    return np.column_stack([found.K_I, found.K_II, found.K_III])


def _modes(off) -> dict[str, list[float]]:
    """Return mean, rms about it and largest size of errors (k, 3) of each mode."""
    figures = (off.mean(axis=0), off.std(axis=0), np.abs(off).max(axis=0))
    return dict(zip(("K_I", "K_II", "K_III"), np.transpose(figures).tolist()))


def off_printed(found, case: Case) -> float:
    """Return by how much K_I over its mean differs at most from the printed one's, in %."""
    wanted, k1 = map(np.array, case.printed)
    offset = found.points[:, :2] - np.array(case.crack["centre"])[:2]
    x, y = (offset / case.crack["semi_axes"]).T
    angle = np.arctan2(y, x)
    order = np.argsort(angle)
    k = np.interp(wanted, angle[order], found.K_I[order])
    return 100 * np.abs(k / k.mean() / (k1 / k1.mean()) - 1).max()


def _kink_error(k, wanted) -> float | None:
    """Return the largest error in degrees where K_I counts; none where it counts nowhere."""
    opens = wanted[:, 0] > 0.1 * np.abs(wanted).max()
    turn = np.degrees(kink(*k[opens, :2].T) - kink(*wanted[opens, :2].T))
    return float(np.abs(turn).max()) if opens.any() else None


def kink(k1, k2):
    """Return the angles (k,) of the maximum tangential stress: Erdogan and Sih."""
    return -2 * np.arctan2(2 * k2, k1 + np.sqrt(k1**2 + 8 * k2**2))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--case", action="append", choices=CASES, help="only this case; several may be given"
    )
    parser.add_argument(
        "--edges", type=float, action="append", help="front edges on the crack's radius (10)"
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures to this file")
    arguments = parser.parse_args()
    rows: list[dict] = []
    for name in arguments.case or CASES:
        for edges in arguments.edges or [10.0]:
            print(f"{name}, a/h {edges:g} ...", file=sys.stderr)
            try:
                rows += in_child(run, name, edges)
            except ChildFailed as error:
                rows.append({"case": name, "method": f"a/h {edges:g}", "failed": str(error)})
            write_json(arguments.json, {"rows": rows})
    print_table(rows, COLUMNS)
    print_table(claims.table(rows), claims.COLUMNS)
    return int(any("failed" in row for row in rows) or not claims.holds(rows))


if __name__ == "__main__":
    sys.exit(main())

"""Cracks whose lips touch, or that the load does not open: which of their points go on, and by what."""

from pathlib import Path

import exact_cracks
import numpy as np

from grown.campaigns import Check, columns, ended, front, grown, off_front, places
from grown.flat import CENTRE, PENNY, RADIUS, in_large_body

INCLINED = np.array([1.0, 0.0, 1.0]) / np.sqrt(2)
GROW = "share: 0.25"
CAP, TILT = 45.0, 60.0  # degrees: half the angle of a cap of a sphere, and of its axis to the tension
MODE_I = 0.015  # largest error of K_I over K_II without friction
MODE_II = 70.53  # kink of the largest tangential stress without K_I, degrees


def closed(folder: Path, friction: float = 0.0) -> list[Check]:
    """Press a penny at 45 degrees: K, less by this coefficient of friction, and the step by it."""
    crack = f"{PENNY}, normal: {INCLINED.tolist()}"
    case = grown(folder, in_large_body(crack, GROW, -1.0, friction), 2, "001/sif.csv")
    k, frame = columns(case, 0), columns(case, 0, "front.csv")
    binormal, tangent = (
        np.stack([frame[f"{name}_{axis}"] for axis in "xyz"], axis=1) for name in ("binormal", "tangent")
    )
    exact = exact_cracks.penny(RADIUS, INCLINED, np.diag([0.0, 0, -1.0]))(binormal, tangent, binormal)
    exact *= 1 - friction  # the pressure on the lips is as large as the shear
    largest = np.abs(exact[:, 1]).max()
    off = [np.abs(k[mode] - exact[:, axis]).max() / largest for mode, axis in (("K_II", 1), ("K_III", 2))]
    goes = k["extension"] > 0
    kink = float(np.median(np.abs(k["kink_angle"][goes])))
    sliding = np.abs(exact[:, 1]) > 0.02 * largest  # twice the doubt of K
    return [
        # Over six meshes of such a penny the largest error of K_I is 0.3 to 1.0 % of K_II. It comes from
        # the pressure, which friction leaves as it is.
        Check(
            "K_I over the largest K_II",
            float(np.abs(k["K_I"]).max() / largest),
            0.0,
            MODE_I / (1 - friction),
        ),
        Check("K_II off the exact one, over it", float(off[0]), 0.0, 0.01),
        Check("K_III off the exact one, over K_II", float(off[1]), 0.0, 0.01),
        Check("points that slide and stay", float((sliding & ~goes).sum()), 0.0, 0.0),
        Check("|kink angle|, degrees, median", kink, MODE_II, 1.0),
    ]


def unopened(folder: Path) -> list[Check]:
    """Press a penny flat, and pull one along its plane: neither goes on, for different reasons."""
    return [
        Check(
            f"ends at once, {word}",
            float(_ends(folder / name, f"{PENNY}, normal: {normal}", stress, word)),
            1.0,
            0.0,
        )
        for name, normal, stress, word in (
            ("pressed", "[0.0, 0.0, 1.0]", -1.0, "noise"),
            ("along", "[1.0, 0.0, 0.0]", 1.0, "noise"),
        )
    ]


def half_closed(folder: Path) -> list[Check]:
    """Pull a cap whose lips are closed on one side: the other side goes on, and the next mesh is solved."""
    folder.mkdir(parents=True, exist_ok=True)
    _write_cap(folder / "cap.vtp")
    case = grown(folder, in_large_body("shape: surface, file: cap.vtp", GROW), 2, "001/sif.csv")
    goes = columns(case, 0)["extension"] > 0
    before, after = (places(columns(case, step, "front.csv")) for step in range(2))
    edge = float(np.linalg.norm(np.diff(before, axis=0), axis=1).mean())
    line = front(case, 1, "crack")
    return [
        Check("share of the points that go on", float(goes.mean()), 0.5, 0.49),
        Check(
            "points that stay off the next front, edges", off_front(line, before[~goes]) / edge, 0.0, 0.05
        ),
        Check("nodes of the next mesh off it, edges", off_front(line, after) / edge, 0.0, 0.02),
    ]


def _write_cap(path: Path) -> None:
    """Write a cap of a sphere whose rim has RADIUS."""
    from scipy.spatial import Delaunay

    from craftmesh.cracks.triangulated import crack_from_triangles
    from craftmesh.io.vtk import write_crack

    rings, half, tilt = 24, np.radians(CAP), np.radians(TILT)
    flat = [np.zeros((1, 2))]
    for ring in range(1, rings + 1):
        turn = np.arange(6 * ring) * np.pi / (3 * ring)
        flat.append(ring / rings * np.column_stack([np.cos(turn), np.sin(turn)]))
    uv = np.concatenate(flat)
    angle = half * np.linalg.norm(uv, axis=1)
    along = uv * (np.sin(angle) / np.maximum(np.linalg.norm(uv, axis=1), 1e-300))[:, None]
    turned = np.array([[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])
    points = np.column_stack([along, np.cos(angle)]) @ turned.T * RADIUS / np.sin(half) + CENTRE
    crack = crack_from_triangles(points, Delaunay(uv).simplices, None, np.array([CENTRE - 50, CENTRE + 50]))
    write_crack(path, crack)


def _ends(folder: Path, crack: str, stress: float, word: str) -> bool:
    case = grown(folder, in_large_body(crack, GROW, stress), 2, "000/growth.json", "until")
    return word in ended(case, 0)

"""Write crack.off, a stand-in for a measured crack: a self-affine height over a half disc."""

from pathlib import Path

import numpy as np
from scipy import ndimage
from scipy.spatial import Delaunay

HURST = 0.78  # fatigue cracks of aluminium: 0.75 to 0.8
SPACING = 12.0  # micrometres between points: two edges of the mesh near the front
RADIUS = 210.0
ROUGHNESS = 15.0  # root mean square of the heights
CENTRE = np.array([0.0, 275.0, 275.0])
GRID = 128  # points of the height's grid along x and y


def heights(rng: np.random.Generator) -> np.ndarray:
    """Return a periodic height (GRID, GRID) whose differences over a distance d grow as d^HURST."""
    wave = np.hypot(*np.meshgrid(np.fft.fftfreq(GRID), np.fft.fftfreq(GRID)))
    wave[0, 0] = np.inf
    found = np.fft.ifft2(np.fft.fft2(rng.normal(size=(GRID, GRID))) * wave ** -(HURST + 1)).real
    return ROUGHNESS * found / found.std()


def main() -> None:
    rng = np.random.default_rng(4)
    angles = np.linspace(-np.pi, np.pi, round(2 * np.pi * RADIUS / SPACING), endpoint=False)
    phase = rng.uniform(0, 2 * np.pi, 4)
    rim = 1 + sum(0.03 / k * np.cos(k * angles + phase[k - 1]) for k in range(1, 5))
    rings = [share * rim for share in np.arange(SPACING, RADIUS, SPACING) / RADIUS] + [rim]
    flat = [np.zeros((1, 2))]
    for ring in rings:
        count = max(round(len(angles) * ring.mean()), 6)
        at = np.linspace(-np.pi, np.pi, count, endpoint=False)
        size = RADIUS * np.interp(at, angles, ring, period=2 * np.pi)
        flat.append(size[:, None] * np.stack([np.cos(at), np.sin(at)], axis=1))
    points = np.concatenate(flat)
    triangles = Delaunay(points).simplices
    triangles = triangles[(points[triangles, 0].max(axis=1) > 0)]  # those within the box, x > 0
    used, triangles = np.unique(triangles, return_inverse=True)
    triangles = triangles.reshape(-1, 3)
    points = points[used]
    place = (points / SPACING * 2 + GRID // 2).T
    height = ndimage.map_coordinates(heights(rng), place, order=1, mode="grid-wrap")
    points = np.column_stack([points, height - height.mean()]) + CENTRE
    with open(Path(__file__).with_name("crack.off"), "w", encoding="ascii", newline="\n") as stream:
        stream.write(f"OFF\n{len(points)} {len(triangles)} 0\n")
        np.savetxt(stream, points, "%.2f")
        np.savetxt(stream, np.column_stack([np.full(len(triangles), 3), triangles]), "%d")


if __name__ == "__main__":
    main()

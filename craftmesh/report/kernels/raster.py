"""Rasterisation of triangles with a depth buffer."""

import numpy as np

from craftmesh.jit import kernel


@kernel
def draw(corners, colours, line, picture, depth):
    """Draw triangles into `picture` (h, w, 3) where they are nearer than `depth` (h, w); update both.

    corners (m, 3, 3): each corner's pixels to the right, pixels down, and nearness to the viewer (larger is
    nearer). A pixel is covered if its centre is in the triangle. colours (m, 3, 3): of the corners, 0 to 1.
    Within `line` (m,) pixels of an edge the colour fades to black.
    """
    height, width = depth.shape
    for t in range(len(corners)):
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = corners[t]
        twice = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if twice == 0.0:
            continue
        # altitudes; a pixel's distance from an edge is its barycentric coordinate times the altitude
        high_a = abs(twice) / np.sqrt((cx - bx) ** 2 + (cy - by) ** 2)
        high_b = abs(twice) / np.sqrt((cx - ax) ** 2 + (cy - ay) ** 2)
        high_c = abs(twice) / np.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
        first = max(0, int(np.ceil(min(ay, by, cy) - 0.5)))
        last = min(height - 1, int(np.floor(max(ay, by, cy) - 0.5)))
        left = max(0, int(np.ceil(min(ax, bx, cx) - 0.5)))
        right = min(width - 1, int(np.floor(max(ax, bx, cx) - 0.5)))
        for i in range(first, last + 1):
            for j in range(left, right + 1):
                x, y = j + 0.5, i + 0.5
                a = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / twice
                b = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / twice
                c = 1.0 - a - b
                if a < 0.0 or b < 0.0 or c < 0.0:
                    continue
                near = a * az + b * bz + c * cz
                if near <= depth[i, j]:
                    continue
                depth[i, j] = near
                edge = min(a * high_a, b * high_b, c * high_c)
                plain = 1.0 if line[t] <= 0.0 else min(1.0, edge / line[t])
                for k in range(3):
                    colour = a * colours[t, 0, k] + b * colours[t, 1, k] + c * colours[t, 2, k]
                    picture[i, j, k] = plain * colour

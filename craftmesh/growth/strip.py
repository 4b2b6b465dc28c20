"""The strip of new crack surface between an old front and a new one."""

import numpy as np


def with_front_points(
    points: np.ndarray, triangles: np.ndarray, front: np.ndarray, spacing: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points, triangles and a front (ids) whose edges are no longer than `spacing`.

    points (n, 3); triangles (m, 3), each directed edge of the front in one of them. The surface stays where
    it is: triangles on longer edges are split.
    """
    places, rows, ids = list(points), triangles.tolist(), [int(front[0])]
    row_of = {(t[k - 1], t[k]): row for row, t in enumerate(rows) for k in range(3)}
    for a, b in zip(front[:-1].tolist(), front[1:].tolist()):
        parts = int(np.ceil(np.linalg.norm(points[b] - points[a]) / spacing))
        tail = a
        for share in np.arange(1, parts) / parts:
            row, new = row_of[tail, b], len(places)
            apex = next(id for id in rows[row] if id not in (tail, b))
            places.append(points[a] + share * (points[b] - points[a]))
            rows[row] = [tail, new, apex]
            rows.append([new, b, apex])
            row_of |= {(tail, new): row, (new, b): len(rows) - 1, (b, apex): len(rows) - 1}
            ids.append(new)
            tail = new
        ids.append(b)
    return np.array(places), np.array(rows), np.array(ids)


def strip_triangles(old: np.ndarray, arc: np.ndarray, new: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Return triangles (m, 3) between the fronts `old` and `new` (ids), turned as the surface behind.

    arc: arc lengths of the old front's points; origin: those that the new front's come from, ascending.
    Each next triangle takes the point that comes first along the old front. Where both fronts have the same
    points there is no triangle, nor has one all its corners on the old front.
    """
    rows, shared = [], set(old.tolist()) & set(new.tolist())
    i, j = 0, 0
    while i < len(old) - 1 or j < len(new) - 1:
        if j == len(new) - 1 or i == len(old) - 1:
            ahead = i < len(old) - 1
        elif old[i] == new[j]:
            ahead = False
        elif new[j + 1] in shared:
            ahead = old[i] != new[j + 1]
        else:
            ahead = arc[i + 1] + arc[i] <= origin[j + 1] + origin[j]
        if ahead:
            rows.append((old[i + 1], old[i], new[j]))
            i += 1
        else:
            rows.append((old[i], new[j], new[j + 1]))
            j += 1
    strip = np.array(rows)
    return strip[(strip != np.roll(strip, 1, axis=1)).all(axis=1)]

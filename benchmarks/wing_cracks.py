"""K and paths of wing cracks in plane strain, by displacement discontinuities (Crouch, 1976).

A straight main crack lies in an infinite body under compression. Its lips slide with friction where they
touch. From each of its ends a wing grows, which friction does not close. The crack is the same after half a
turn, so the unknown jumps of displacement are those of one half. Points are complex numbers x + i z; the
tension is positive; E / (1 - nu^2) is 1.
"""

import numpy as np

EDGE = 0.01  # length of elements away from kinks, over half of the main crack's length
FINEST, RATIO = 0.003, 1.2  # the smallest element at the kink over EDGE, and the growth of its neighbours
# Distance from the last element's end to the tip, over its length, with which the opening of a straight
# crack of equal elements is exact to 5e-5, and the factor of its tip element's jump in K.
BEYOND, FACTOR = 0.25, 1 / np.sqrt(8)
FIRST = 1.2  # radians: the first guess of the wing's angle to the main crack
STILL, TURNS = 1e-3, 12  # largest |K_II| / K_I at the end of a step of a path, and number of guesses


def tip_k(corners, stress, friction: float) -> np.ndarray:
    """Return K_I and K_II at the tip of the wing; K_II > 0 turns the wing clockwise.

    corners (k,): from the main crack's end along the wing to its tip, around the main crack's middle 0;
    stress: xx, zz and xz far away; friction: coefficient of the main crack's lips, which slide everywhere.
    """
    nodes, main = _nodes(np.asarray(corners))
    step = np.diff(nodes)
    tangent, middle, count = step / np.abs(step), nodes[:-1] + step / 2, len(step)
    slide, open_ = (_tractions(nodes, middle, tangent, jump) for jump in (tangent, 1j * tangent))
    load = far_traction(tangent, stress)
    on_main, unit = np.arange(count) < main, np.eye(count)
    closed = on_main
    for _ in range(TURNS):
        drag = np.where(closed, np.sign(load.imag[0]) * friction, 0.0)
        rows = [[one.imag + drag[:, None] * one.real for one in (slide, open_)]]
        rows += [[np.where(closed[:, None], still, one.real) for still, one in ((0, slide), (unit, open_))]]
        right = -np.concatenate([load.imag + drag * load.real, np.where(closed, 0.0, load.real)])
        slip, gap = np.linalg.solve(np.block(rows), right).reshape(2, count)
        pressed = slide.real @ slip + open_.real @ gap + load.real < 0
        before, closed = closed, on_main & np.where(closed, pressed, gap < 0)
        if (closed == before).all():
            break
    return FACTOR * np.array([gap[-1], slip[-1]]) / np.sqrt(abs(step[-1]))


def wing_path(end: complex, stress, friction: float, step: float, count: int) -> np.ndarray:
    """Return corners (count + 1,) of a wing in straight steps, each of which ends with K_II = 0.

    end: of the main crack, whose middle is 0; stress, friction: as in `tip_k`.
    """
    corners, way = [end], end / abs(end)
    guess = -FIRST * np.sign(far_traction(way, stress).imag)
    for _ in range(count):
        angles, found = [guess, guess + 0.05], []
        for _ in range(TURNS):
            tip = corners[-1] + step * way * np.exp(1j * angles[len(found)])
            found.append(tip_k([*corners, tip], stress, friction))
            if abs(found[-1][1]) <= STILL * found[-1][0]:
                break
            if len(found) > 1:
                (_, before), (_, now) = found[-2:]
                angles.append(angles[-1] - now * (angles[-1] - angles[-2]) / (now - before))
        way, guess = (tip - corners[-1]) / step, 0.0
        corners.append(tip)
    return np.array(corners)


def far_traction(tangent, stress):
    """Return normal + i shear traction (n,) of a stress xx, zz, xz on lines along unit tangents (n,)."""
    xx, zz, xz = stress
    return (xx + zz) / 2 + tangent**2 * ((zz - xx) / 2 + 1j * xz)


def _nodes(corners) -> tuple[np.ndarray, int]:
    """Return nodes (n + 1,) from the main crack's middle to the wing's tip, and its number of elements."""
    half = abs(corners[0])
    main = half - _distances(half, EDGE * half, 0.0)[::-1]
    along = np.concatenate([[0], np.cumsum(np.abs(np.diff(corners)))])
    at = _distances(along[-1], EDGE * half, BEYOND)[1:]
    return np.concatenate([corners[0] / half * main, np.interp(at, along, corners)]), len(main) - 1


def _distances(length: float, edge: float, beyond: float) -> np.ndarray:
    """Return distances of nodes from a kink, the last one `beyond` elements before `length`."""
    growing = int(np.ceil(-np.log(FINEST) / np.log(RATIO)))
    sizes = edge * np.minimum(FINEST * RATIO ** np.arange(growing + 1 + int(length / edge)), 1)
    count = max(np.searchsorted(np.cumsum(sizes) + beyond * sizes, length), 1)
    at = np.concatenate([[0], np.cumsum(sizes[:count])])
    return at * length / (at[-1] + beyond * sizes[count - 1])


def _tractions(nodes, middle, tangent, jump) -> np.ndarray:
    """Return normal + i shear tractions (n, n) at middles by unit jumps (n,) on elements and their images.

    A jump is a pair of dislocations at its element's ends. After half a turn the jump is the same and its
    element runs the other way.
    """
    total = np.zeros((len(middle), len(jump)), complex)
    for sign, ends in ((-1, nodes[:-1]), (1, nodes[1:])):
        for side in (1, -1):
            burgers, place = sign * side * jump / (8j * np.pi), side * ends
            off = middle[:, None] - place
            bend = (np.conj(burgers) + burgers * np.conj(place - middle[:, None]) / off) / off
            total += 2 * (burgers / off).real + tangent[:, None] ** 2 * bend
    return total

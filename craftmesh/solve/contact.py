"""Contact of a crack's lips: an active set finds the pairs of nodes that are closed."""

from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from craftmesh.errors import CraftmeshError
from craftmesh.mesh.front_curve import unit
from craftmesh.mesh.lips import LipPairs
from craftmesh.solve.friction import friction_at_rest, next_friction
from craftmesh.solve.iteration import ClosedPairs, Found, Iteration

# Smallest overlap of lips that counts, over tolerance times the span of the displacements.
_OVERLAP = 100.0
# Residual of fields that only decide which pairs close: the overlaps and forces that decide are larger.
_ROUGH = 1e-5
# Largest number of releases of a pair. A pair that closes again after these stays closed.
_MOST_RELEASES = 3
_MOST_STEPS = 100  # largest number of changes of the closed pairs


class Contact(NamedTuple):
    """The field with contact, and how it was found.

    closed, sticks (p,): masks of the pairs of opposite lip nodes whose gap is closed, and of those that
    friction keeps from sliding too; steps: number of active sets tried; overlap: the largest overlap that
    is left, a length.
    """

    found: Found
    closed: np.ndarray
    sticks: np.ndarray
    steps: int
    overlap: float

    def figures(self) -> dict[str, int | float]:
        """Return the numbers of contact for a solution's record.

        The keys are contact_pairs, contact_closed, contact_sticking, contact_steps, and overlap, a length.
        """
        return {
            "contact_pairs": len(self.closed),
            "contact_closed": int(self.closed.sum()),
            "contact_sticking": int(self.sticks.sum()),
            "contact_steps": self.steps,
            "overlap": self.overlap,
        }


def overlap_of(pairs: LipPairs, displacement: np.ndarray) -> float:
    """Return the largest overlap of the lips in a field (n, 3), 0 if they do not overlap."""
    return float(max(-pairs.gaps(displacement).min(initial=0.0), 0.0))


def least_overlap(displacement: np.ndarray, tolerance: float) -> float:
    """Return the overlap above which lips count as overlapping in a field (n, 3) of that residual.

    tolerance: the field's residual.
    """
    return _OVERLAP * tolerance * float(np.ptp(displacement, axis=0).max())


def with_contact(iteration: Iteration, pairs: LipPairs, start: np.ndarray, coefficient: float) -> Contact:
    """Return the field whose lips press on each other where they touch; start (n, 3): without contact.

    Primal-dual active set (Hintermueller, Ito & Kunisch 2002): pairs that overlap are closed and pairs that
    pull are released, until there are none of either, except pairs already released _MOST_RELEASES times.
    A corner of 10-node elements is released only if the pressure around it pulls too, because uniform
    pressure puts no force on corners. coefficient: of friction; the load acts in one step, so that friction
    depends on the slip from the body at rest. Raises CraftmeshError after _MOST_STEPS steps.
    """
    tolerance, fixed = iteration.options.tolerance, iteration.problem.supports.fixed
    around, axes = _around(pairs), _axes(pairs.normal)
    closed = pairs.gaps(start) < -least_overlap(start, tolerance)
    aim, displacement = max(_ROUGH, tolerance), start
    releases = np.zeros(len(closed), int)
    friction = friction_at_rest(pairs, coefficient)
    for step in range(1, _MOST_STEPS + 1):
        text = f"contact {step}, {closed.sum()} of {len(closed)} pairs closed, "
        sticks, slides = closed & friction.sticks, (closed & ~friction.sticks)[:, None]
        held = np.column_stack([closed, sticks, sticks])
        rubbing = friction.drag * slides, friction.spring * slides
        found = iteration.solved(displacement, ClosedPairs(pairs, axes, held, rubbing, fixed, text), aim)
        displacement, least = found.displacement, aim * found.size
        push, _ = pairs.split(found.push)
        pulls = (push < -least) & (push + around @ push < -least)
        opens = closed & pulls & (releases < _MOST_RELEASES)
        closes = ~closed & (pairs.gaps(displacement) < -least_overlap(displacement, aim))
        friction = next_friction(
            friction, pairs, around, coefficient, displacement, found.push, closed, least
        )
        if friction.settled and not (opens | closes).any():
            if aim == tolerance:
                return Contact(found, closed, sticks, step, overlap_of(pairs, displacement))
            aim = tolerance
        closed = (closed & ~opens) | closes
        releases += opens
    raise CraftmeshError(
        f"contact: which lip nodes touch or slide still changes after {_MOST_STEPS} steps; look for flat "
        "elements (craftmesh check), lower lip_friction, or set contact to false"
    )


def _axes(normal: np.ndarray) -> np.ndarray:
    """Return three orthonormal axes (p, 3, 3) as rows, the first of which is the normal (p, 3)."""
    other = np.eye(3)[np.abs(normal).argmin(axis=1)]
    first = unit(np.cross(normal, other))
    return np.stack([normal, first, np.cross(normal, first)], axis=1)


def _around(pairs: LipPairs) -> csr_array:
    """Return the matrix (p, p) that gives each corner half of the forces at the mid nodes of its edges.

    With the corner's own force, this is the force on the linear function that is 1 at the corner. It is 0
    for 4-node elements, which have no mid nodes.
    """
    count = len(pairs.nodes)
    if pairs.facets.shape[1] == 3:
        return csr_array((count, count))
    mids, corners = pairs.facets[:, [3, 4, 5, 3, 4, 5]].ravel(), pairs.facets[:, [0, 1, 2, 1, 2, 0]].ravel()
    known = (mids >= 0) & (corners >= 0)
    rows = np.unique(np.stack([corners[known], mids[known]], axis=1), axis=0)
    return csr_array((np.full(len(rows), 0.5), tuple(rows.T)), (count, count))

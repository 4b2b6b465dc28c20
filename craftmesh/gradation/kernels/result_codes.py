"""Result codes of operations, and the bits of a vertex's flags."""

from craftmesh.jit import lean_kernel

# Results that are no refusals: the operation was done; the operation was not needed, or its edge or vertex
# no longer exists.
DONE = -1
NO_NEED = -2
# Reasons of refusal, and their names in the report.
JUNCTION, CONSTRAINT, LINK, JUNCTION_TRIANGLE, GRAIN_CONTACT = range(5)
ANGLE, NORMAL, LENGTH, DISTANCE, VOLUME, EAR, CHORD, INTERSECTION, WEDGE = range(5, 14)
REFUSALS = {
    JUNCTION: "junction",
    CONSTRAINT: "constraint",
    LINK: "link",
    JUNCTION_TRIANGLE: "junction_triangle",
    GRAIN_CONTACT: "grain_contact",
    ANGLE: "angle",
    NORMAL: "normal",
    LENGTH: "length",
    DISTANCE: "distance",
    VOLUME: "volume",
    EAR: "ear",
    CHORD: "chord",
    INTERSECTION: "intersection",
    WEDGE: "wedge",
}
# Bits of a vertex's flags: 1 << (k - 1) for the box plane of kind k (1 to 6, two planes per axis), which
# together are ON_PLANES; then one bit each for crack, front and border.
ON_PLANES = 63
ON_CRACK = 64
ON_FRONT = 128
ON_BORDER = 256


@lean_kernel
def is_held(flags, axis):
    """Return whether a border, or a box plane perpendicular to `axis`, fixes the vertex' coordinate."""
    return flags & ON_BORDER != 0 or (flags >> (2 * axis)) & 3 != 0


@lean_kernel
def counted(refused, answer):
    """Return 1 if the result `answer` is DONE, else 0; count a refusal in `refused` by its reason."""
    if answer >= 0:
        refused[answer] += 1
    return 1 if answer == DONE else 0

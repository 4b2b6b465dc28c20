"""What the faces of the box bear, row by row: "ZMIN.z=fixed", "ZMAX.z=strain:0.001", "ZMAX.x=stress:30"."""

import math
from collections.abc import Iterable
from typing import NamedTuple

from craftmesh.errors import CraftmeshError
from craftmesh.types import BOX_PLANES

FIXED, STRAIN, STRESS = "fixed", "strain", "stress"
_EXPECTED = (
    f"expected FACE.AXIS={FIXED}, FACE.AXIS={STRAIN}:VALUE or FACE.AXIS={STRESS}:VALUE, with a FACE of "
    f"{', '.join(BOX_PLANES)} and an AXIS of x, y, z"
)


class FaceRow(NamedTuple):
    """What a plane of the box bears along an axis (0, 1, 2), its normal or one in it.

    kind: FIXED; STRAIN, the displacement over the box's length across the plane; or STRESS, the component
    of the stress. Both count along the axis on far planes and against it on near ones, as the traction of a
    stress does: the same value on both is a uniform tension or shear.
    """

    plane: str
    axis: int
    kind: str
    value: float = 0.0

    @property
    def across(self) -> int:
        """The axis (0, 1, 2) that the plane is square to."""
        return "XYZ".index(self.plane[0])

    @property
    def along(self) -> float:
        """The value along the axis."""
        return self.value if self.plane.endswith("MAX") else -self.value


def parse_faces(texts: Iterable[str]) -> tuple[FaceRow, ...]:
    """Return the rows of texts; raises CraftmeshError for other texts, and for two of one face and axis."""
    rows: dict[tuple[str, int], FaceRow] = {}
    for text in texts:
        place, _, what = text.partition("=")
        plane, _, axis = place.strip().partition(".")
        kind, colon, value = what.strip().partition(":")
        known = plane.upper() in BOX_PLANES and axis in ("x", "y", "z")
        number = _number(value)
        if not known or not (number is not None if kind in (STRAIN, STRESS) else what.strip() == FIXED):
            raise CraftmeshError(f"faces: {text!r}; {_EXPECTED}")
        row = FaceRow(plane.upper(), "xyz".index(axis), kind, number or 0.0)
        if kind == STRAIN and abs(row.value) > 1:
            raise CraftmeshError(
                f"faces: {text!r} moves the face by more than the body's length; expected a small strain "
                "such as 0.001"
            )
        if row[:2] in rows:
            raise CraftmeshError(f"faces: {text!r} is a second row for {place.strip()}; keep one")
        rows[row[:2]] = row
    return tuple(rows.values())


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None

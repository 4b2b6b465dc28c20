"""What the faces of the box bear, row by row: "ZMIN.z=fixed", "ZMAX.z=strain:0.001", "ZMAX.x=stress:30"."""

import math
from collections.abc import Iterable
from typing import NamedTuple

from craftmesh.errors import CraftmeshError
from craftmesh.types import BOX_PLANES

FIXED, STRAIN, STRESS = "fixed", "strain", "stress"
_EXPECTED = (
    f"expected FACE.AXIS={FIXED}, FACE.AXIS={STRAIN}:VALUE or FACE.AXIS={STRESS}:VALUE, with a FACE of "
    f"{', '.join(BOX_PLANES)} and an AXIS of x, y, z, or AXIS={STRESS}:VALUE for a tension, and perhaps "
    "CASE/ before it"
)


class FaceRow(NamedTuple):
    """What a plane of the box bears along an axis (0, 1, 2), its normal or one in it.

    kind: FIXED; STRAIN, the displacement over the box's length across the plane; or STRESS, the component
    of the stress. Both count along the axis on far planes and against it on near ones, as the traction of a
    stress does: the same value on both is a uniform tension or shear. case: the load case of the row, ""
    for all.
    """

    plane: str
    axis: int
    kind: str
    value: float = 0.0
    case: str = ""

    @property
    def across(self) -> int:
        """The axis (0, 1, 2) that the plane is square to."""
        return "XYZ".index(self.plane[0])

    @property
    def along(self) -> float:
        """The value along the axis."""
        return self.value if self.plane.endswith("MAX") else -self.value


def parse_faces(texts: Iterable[str]) -> tuple[FaceRow, ...]:
    """Return the rows of texts; raises CraftmeshError for other texts."""
    return tuple(row for text in texts for row in _rows(text))


def _rows(text: str) -> list[FaceRow]:
    """Return the row of a text, and where it names an axis in place of a face the near face's, fixed."""
    place, _, what = text.partition("=")
    case, _, place = (part.strip() for part in place.rpartition("/"))
    is_tension = place in ("x", "y", "z")
    plane, _, axis = (f"{place}max", "", place) if is_tension else place.partition(".")
    kind, _, value = (part.strip() for part in what.partition(":"))
    number = number_of(value)
    is_kind = number is not None if kind in (STRAIN, STRESS) else what.strip() == FIXED
    if plane.upper() not in BOX_PLANES or axis not in ("x", "y", "z") or not is_kind:
        raise CraftmeshError(f"faces: {text!r}; {_EXPECTED}")
    if kind == STRAIN and abs(number or 0.0) > 1:
        raise CraftmeshError(
            f"faces: {text!r} moves the face by more than the body's length; expected a small strain such "
            "as 0.001"
        )
    row = FaceRow(plane.upper(), "xyz".index(axis), kind, number or 0.0, case)
    return [row._replace(plane=f"{plane[0].upper()}MIN", kind=FIXED, value=0.0), row][not is_tension :]


def number_of(text: str) -> float | None:
    """Return the finite number that a text is, None for any other text."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None

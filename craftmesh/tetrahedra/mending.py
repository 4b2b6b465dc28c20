"""The surface as the grains are cut from it: repaired where facets intersect."""

from dataclasses import dataclass

from craftmesh.surface.repair import repair_surface
from craftmesh.types import Surface


@dataclass(frozen=True)
class Mended:
    """A surface to cut grains from, and what was done to it.

    report: that of `repair_surface`, faulty: the facets as they were, warning: all of it in one line; each
    is None where nothing was at fault.
    """

    surface: Surface
    report: dict | None = None
    faulty: Surface | None = None
    warning: str | None = None


def mended(surface: Surface) -> Mended:
    """Return the surface with points of facets that intersect or are degenerate moved."""
    found, report = repair_surface(surface)
    if not report["faults"]:
        return Mended(surface)
    rows = report["facets"]
    faulty = Surface(surface.points, surface.facets[rows], surface.sides[rows], surface.kind[rows])
    warning = (
        f"{report['faults']} facets of the surface intersect or are degenerate, at grains "
        f"{', '.join(map(str, report['grains'][:6]))}: {report['points_moved']} points were moved by up to "
        f"{report['largest_move']:.3g}, {report['largest_move_edges']:.2g} edges there, "
        f"{report['faults_left']} such facets are left, the largest change of a volume is "
        f"{100 * report['volume_drift_worst']:.2g} %"
    )
    return Mended(found, report, faulty, warning)

"""What makes a crack that came in by voxels worse than a cut one would be."""

import numpy as np

from craftmesh.insertion.misfit import FACETS_OFF, FRONT_OFF
from craftmesh.mesh.poor import FLAT_DIHEDRALS
from craftmesh.surface.front import front_edges
from craftmesh.surface.patches import feature_edges
from craftmesh.surface.wedges import sharp_wedges
from craftmesh.types import CRACK, Surface

# Of the least length: the least width of a strip between the crack's front and another line. No operation
# of the gradation closes a strip. On the crack 0.004 left a deck with 2 flat tetrahedra, 0.03 facets of 6
# degrees; of 19 other random cracks the narrowest were 0.053, with facets of 6 too, and 0.11. Past the
# front, on a grain boundary, 0.001 left a flat one; of 24 others the narrowest were 0.049 and 0.052.
NARROW = 0.05


def fault_of(surface: Surface, report: dict, least: float) -> str | None:
    """Return why a crack by voxels had better be cut: off the given one, in a flat wedge, a narrow strip.

    report: of insert_split. least: the least target length on the crack's fronts.
    """
    off = {name: report[name] / least for name in ("crack_off_most", "front_off_most")}
    if off["crack_off_most"] > FACETS_OFF or off["front_off_most"] > FRONT_OFF:
        return (
            f"voxels leave the crack {off['crack_off_most']:.2g} l_min off the given one and its front "
            f"{off['front_off_most']:.2g}; expected {FACETS_OFF} and {FRONT_OFF} at most"
        )
    wedges = sharp_wedges(surface)
    flattest = wedges.angle[(surface.kind[wedges.facets] == CRACK).any(axis=1)].min(initial=180.0)
    if flattest < FLAT_DIHEDRALS[0]:
        return (
            f"voxels leave a wedge of {flattest:.2g} degrees between the crack and what is beside it; "
            f"expected {FLAT_DIHEDRALS[0]:g} at least"
        )
    width = narrowest_strip(surface) / least
    if width < NARROW:
        return (
            f"voxels leave a strip {width:.2g} l_min wide between the crack's front and another line; "
            f"expected {NARROW} at least"
        )
    return None


def narrowest_strip(surface: Surface) -> float:
    """Return the length of the shortest edge across a patch from the front to another line, or infinity.

    Lines are junction lines, traces of grain boundaries and mouths among them.
    """
    edges, _, _, is_line = feature_edges(surface)
    on_front, on_line = np.zeros((2, len(surface.points)), bool)
    on_front[front_edges(surface)] = True
    on_line[edges[is_line]] = True
    first, second = edges.T
    crosses = ~is_line & on_line[first] & on_line[second] & (on_front[first] != on_front[second])
    ends = surface.points[edges[crosses]]
    return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).min(initial=np.inf))

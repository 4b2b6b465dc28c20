"""A load as data: nodes that are held or moved, and tractions on faces."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.faces import FIXED, STRAIN, STRESS, FaceRow
from craftmesh.mechanics.rigid_body_supports import lacking
from craftmesh.mesh.front_curve import unit
from craftmesh.mesh.integration import face_points
from craftmesh.mesh.mesh_sets import node_sets_of
from craftmesh.mesh.tet_connectivity import FACE_CORNERS, face_nodes
from craftmesh.surface.rounding import ROUNDING
from craftmesh.types import BOX_PLANES, TetMesh

# Points and weights with which Abaqus and CalculiX integrate pressures on faces of C3D4 and of C3D10.
_DECK_RULES = {
    4: (np.array([[1 / 3, 1 / 3]]), np.array([1 / 2])),
    10: (np.array([[1 / 6, 1 / 6], [2 / 3, 1 / 6], [1 / 6, 2 / 3]]), np.full(3, 1 / 6)),
}
# Corners 0 to 7 of the unit cube, x fastest, and six tetrahedra around its diagonal.
_CORNERS = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
_TETS = np.array(
    [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]], np.int32
)


@dataclass(frozen=True, eq=False)
class Traction:
    """A stress on a face set; faces (f, 2): rows of (element, side).

    axis: direction (0, 1, 2) of the traction; None: along the outward normals, tension > 0. stress: one
    value for all faces, or values (f, q) at their q integration points (`face_points`).
    """

    faces: np.ndarray
    stress: float | np.ndarray
    name: str
    axis: int | None = None


def point_vectors(traction: Traction, area: np.ndarray) -> np.ndarray:
    """Return a traction as vectors (f, q, 3) at the q integration points of its faces (`face_points`).

    area (f, q, 3): area vectors at these points.
    """
    way = np.eye(3)[[[traction.axis]]] if traction.axis is not None else unit(area)
    return np.broadcast_to(traction.stress, area.shape[:2])[:, :, None] * way


def nodal_forces(tractions: Iterable[Traction], mesh: TetMesh) -> np.ndarray:
    """Return the nodal forces (n, 3) of tractions on a mesh, consistent with its shape functions.

    A uniform stress is integrated with the points of the deck's solvers, which receive the stress itself.
    """
    forces = np.zeros(mesh.points.shape)
    for traction in tractions:
        nodes, is_even = face_nodes(mesh.tets, traction.faces), not np.ndim(traction.stress)
        at = face_points(mesh.points[nodes], _DECK_RULES[mesh.tets.shape[1]] if is_even else None)
        force = at.area
        if traction.axis is not None:
            force = np.linalg.norm(force, axis=2, keepdims=True) * np.eye(3)[traction.axis]
        force = np.broadcast_to(traction.stress, force.shape[:2])[:, :, None] * force
        np.add.at(forces, nodes, at.value.T @ force)
    return forces


@dataclass(frozen=True, eq=False)
class Fixed:
    """Nodes (k,) whose displacement along `axis` (0, 1, 2) is prescribed: one value, or one per node (k,).

    The value 0 holds the nodes. name: the node set of the mesh that they form, empty for single nodes.
    """

    nodes: np.ndarray
    axis: int
    displacement: float | np.ndarray = 0.0
    name: str = ""


@dataclass(frozen=True, eq=False)
class Load:
    """The load of one static step.

    held: prescribed displacements that act before the step and throughout it, such as supports; moved,
    pulled: displacements and tractions that the step applies; heat: factor of the grains' eigenstrains.
    """

    held: tuple[Fixed, ...]
    moved: tuple[Fixed, ...] = ()
    pulled: tuple[Traction, ...] = ()
    heat: float = 0.0

    def with_lengths(self, scale: float) -> "Load":
        """Return the load in another unit of length: displacements times `scale`, the same stresses."""
        held, moved = (
            tuple(replace(fixed, displacement=scale * fixed.displacement) for fixed in part)
            for part in (self.held, self.moved)
        )
        return Load(held, moved, self.pulled, self.heat)


def acting_faces(loads: Iterable[Load]) -> list[tuple[str, int]]:
    """Return the faces of the box that loads move or pull, each with the axis (0, 1, 2) of its load.

    Faces that are only held (displacement 0) are left out.
    """
    found: dict[tuple[str, int], None] = {}
    for load in loads:
        found |= {
            (part.name, part.axis): None for part in (*load.held, *load.moved) if np.any(part.displacement)
        }
        for one in load.pulled:
            if one.name in BOX_PLANES:
                found[one.name, BOX_PLANES.index(one.name) // 2 if one.axis is None else one.axis] = None
    return list(found)


def face_loop(
    mesh: TetMesh, plane: str, axis: int, nodes: np.ndarray, displacement: np.ndarray, force: np.ndarray
) -> dict[str, np.ndarray]:
    """Return the nominal strain (k,) and stress (k,) of a face along an axis at k times.

    The keys are "FACE.AXIS strain" and "FACE.AXIS stress". Values count along the axis on MAX faces and
    against it on MIN faces. displacement (k, n, 3): of the face's nodes, ids (n,); force (k, 3): total
    force on the face. The strain is the mean displacement over the face, divided by the box's length normal
    to it, the stress the force divided by the box's cross-section.
    """
    across, sign = BOX_PLANES.index(plane) // 2, 1.0 if plane.endswith("MAX") else -1.0
    lengths = np.ptp(mesh.box, axis=0)
    weights = nodal_forces([Traction(mesh.face_sets[plane], 1.0, plane, axis)], mesh)[nodes, axis]
    mean = displacement[:, :, axis] @ weights / weights.sum()
    area = np.delete(lengths, across).prod()
    name = f"{plane}.{'xyz'[axis]}"
    return {f"{name} strain": sign * mean / lengths[across], f"{name} stress": sign * force[:, axis] / area}


def combined(parts: Sequence[tuple[float, Load]]) -> Load:
    """Return the weighted sum of loads; parts: (factor, load) each.

    The loads should have the same supports (not checked): a support of any part is a support of the sum.
    All prescribed displacements of the sum are in `held`. A single part of factor 1 is returned unchanged.
    """
    if len(parts) == 1 and parts[0][0] == 1:
        return parts[0][1]
    held: dict[tuple, Fixed] = {}
    for factor, load in parts:
        for part in (*load.held, *load.moved):
            key = part.name, part.axis, *part.nodes[: not part.name]
            before = held[key].displacement if key in held else 0.0
            held[key] = replace(part, displacement=before + factor * part.displacement)
    pulled: dict[tuple, Traction] = {}
    for factor, load in parts:
        for one in load.pulled:
            key = one.name, one.axis
            stress = pulled[key].stress if key in pulled else 0.0
            pulled[key] = replace(one, stress=stress + factor * one.stress)
    heat = sum(factor * load.heat for factor, load in parts)
    return Load(tuple(held.values()), (), tuple(pulled.values()), heat)


def tension(
    mesh: TetMesh,
    axis: int,
    magnitude: float,
    by_stress: bool,
    rollers: bool,
    lips: Sequence[Traction] = (),
) -> Load:
    """Return the load that pulls the MAX plane of `axis` (0, 1, 2) away from the MIN plane, which is held.

    magnitude: the strain between both planes, or with by_stress the stress on the MAX plane. With rollers
    the MIN planes of the other axes are held along their normals, as planes of symmetry. Without rollers
    two nodes of the MIN plane are held against rotation and sliding. lips: tractions on crack faces.
    Raises CraftmeshError if a plane has no nodes or the stresses would move a body, as `load_on`.
    """
    near, far = (f"{'XYZ'[axis]}{end}" for end in ("MIN", "MAX"))
    rows = near_planes(range(3) if rollers else [axis])
    rows.append(FaceRow(far, axis, STRESS if by_stress else STRAIN, magnitude))
    _check_planes(mesh, rows)
    holds = () if rollers else _against_turning(mesh, axis, mesh.node_sets[near])
    return load_on(mesh, rows, holds, lips)


def near_planes(axes: Iterable[int]) -> list[FaceRow]:
    """Return the rows that hold the MIN planes of axes (0, 1, 2) along their normals."""
    return [FaceRow(f"{'XYZ'[axis]}MIN", axis, FIXED) for axis in axes]


def load_on(
    mesh: TetMesh,
    rows: Sequence[FaceRow],
    holds: Sequence[Fixed] = (),
    lips: Sequence[Traction] = (),
    heat: float = 0.0,
) -> Load:
    """Return the load of rows on the box's faces, other held nodes, tractions on lips and eigenstrains.

    holds: further supports; lips: tractions on crack faces; heat: factor of the eigenstrains. Each body of
    the mesh, such as one that a crack has severed, gets the fewest extra supports that keep it from moving
    as a whole. Raises CraftmeshError for a plane without nodes, for planes that prescribe different
    displacements to a common edge, and for stresses that would move a body.
    """
    _check_planes(mesh, rows)
    held = [Fixed(mesh.node_sets[row.plane], row.axis, name=row.plane) for row in rows if row.kind == FIXED]
    spans = np.ptp(mesh.box, axis=0)
    moved = [
        Fixed(mesh.node_sets[row.plane], row.axis, float(row.along * spans[row.across]), row.plane)
        for row in rows
        if row.kind == STRAIN
    ]
    _check_edges([*held, *moved])
    held += holds
    pulled = (*(_pulled(mesh, row) for row in rows if row.kind == STRESS), *lips)
    # Supports are sorted, so that load cases that hold the same faces get the same extra supports.
    supports = sorted(
        ((fixed.nodes, fixed.axis) for fixed in (*held, *moved)),
        key=lambda part: (part[1], len(part[0]), part[0].tolist()),
    )
    more = lacking(mesh, supports, nodal_forces(pulled, mesh))
    held += [Fixed(np.array([node]), axis) for node, axis in more]
    return Load(tuple(held), tuple(moved), pulled, heat)


def _check_planes(mesh: TetMesh, rows: Sequence[FaceRow]) -> None:
    for row in rows:
        if not len(mesh.node_sets.get(row.plane, ())):
            raise CraftmeshError(
                f"load: the mesh has no nodes on {row.plane}; choose another face or axis, sides free, or "
                "load none"
            )


def _check_edges(parts: Sequence[Fixed]) -> None:
    """Raise CraftmeshError if planes prescribe different displacements to the edge in which they meet."""
    for k, one in enumerate(parts):
        for other in parts[:k]:
            gap = abs(float(one.displacement) - float(other.displacement))
            same = gap <= ROUNDING * max(abs(float(one.displacement)), abs(float(other.displacement)))
            if one.axis == other.axis and one.name[0] != other.name[0] and not same:
                raise CraftmeshError(
                    f"load: {other.name} moves along {'xyz'[one.axis]} by {other.displacement:g} and "
                    f"{one.name} by {one.displacement:g}, and they meet in an edge; prescribe one, with a "
                    "stress on the other"
                )


def _pulled(mesh: TetMesh, row: FaceRow) -> Traction:
    faces = mesh.face_sets.get(row.plane, np.zeros((0, 2), np.int64))
    if row.axis == row.across:
        return Traction(faces, float(row.value), row.plane)
    return Traction(faces, float(row.along), row.plane, row.axis)


def _against_turning(mesh: TetMesh, axis: int, nodes: np.ndarray) -> list[Fixed]:
    """Return supports that prevent sliding and rotation of a plane normal to `axis`; nodes (k,): its nodes.

    u and v are the other two axes. A corner node is held along u and v, a node far along u only along v.
    """
    u, v = (other for other in range(3) if other != axis)
    points = mesh.points[nodes]
    corner = np.lexsort((points[:, v], points[:, u]))[0]
    far = np.lexsort((np.abs(points[:, v] - points[corner, v]), -points[:, u]))[0]
    at_corner, at_far = nodes[[corner]], nodes[[far]]
    return [Fixed(at_corner, u), Fixed(at_corner, v), Fixed(at_far, v)]


def check_faces(rows: Sequence[FaceRow]) -> None:
    """Raise CraftmeshError if `load_on` rejects the rows on a cube of edge 1."""
    corners, grain = _CORNERS[_TETS[:, FACE_CORNERS]], np.ones(len(_TETS), np.int32)
    face_sets = {
        plane: np.argwhere((corners[..., number // 2] == number % 2).all(axis=2))
        for number, plane in enumerate(BOX_PLANES)
    }
    cube = TetMesh(_CORNERS, _TETS, grain, node_sets_of(_TETS, face_sets, []), face_sets)
    try:
        load_on(cube, rows)
    except CraftmeshError as error:
        raise CraftmeshError(
            f"faces cannot be applied (tested on a unit cube): {str(error).removeprefix('load: ')}"
        ) from None

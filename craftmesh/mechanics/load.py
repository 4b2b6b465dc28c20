"""The load of a tension test as data: which nodes are held, moved or under traction, and how."""

from dataclasses import dataclass, replace

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.holding import lacking
from craftmesh.types import TetMesh


@dataclass(frozen=True, eq=False)
class Fixed:
    """Nodes (k,) whose displacement along `axis` (0, 1, 2) is prescribed: one value, or one each (k,).

    0 holds them. name: the node set of the mesh that they are, empty for single nodes.
    """

    nodes: np.ndarray
    axis: int
    displacement: float | np.ndarray = 0.0
    name: str = ""


@dataclass(frozen=True, eq=False)
class Traction:
    """A stress along the outward normals of a face set: faces (f, 2) of elements and sides; tension > 0."""

    faces: np.ndarray
    stress: float
    name: str


@dataclass(frozen=True, eq=False)
class Load:
    """One static step: `held` before and throughout it, then `moved` or `pulled` in it."""

    held: tuple[Fixed, ...]
    moved: tuple[Fixed, ...] = ()
    pulled: tuple[Traction, ...] = ()

    def with_lengths(self, scale: float) -> "Load":
        """Return the load in another unit of length: displacements times `scale`, the same stresses."""
        held, moved = (
            tuple(replace(fixed, displacement=scale * fixed.displacement) for fixed in part)
            for part in (self.held, self.moved)
        )
        return Load(held, moved, self.pulled)


def tension(mesh: TetMesh, axis: int, magnitude: float, by_stress: bool, rollers: bool) -> Load:
    """Return the load that pulls the far plane of `axis` (0, 1, 2) away from the near one, which is held.

    magnitude: the strain between both planes, or with by_stress the stress on the far one. With rollers the
    near planes of the other axes are held along their normals, as planes of symmetry; without, the body is
    held against turning and sliding at two nodes of the near plane. Bodies that a crack has severed get as
    few more supports as keep them from moving as a whole. Raises CraftmeshError for a plane without nodes,
    and for a stress that would pull off what nothing holds.
    """
    near, far = (f"{'XYZ'[axis]}{end}" for end in ("MIN", "MAX"))
    planes = [(k, f"{'XYZ'[k]}MIN") for k in range(3) if rollers or k == axis]
    for name in (*(name for _, name in planes), far):
        if not len(mesh.node_sets.get(name, ())):
            raise CraftmeshError(
                f"load: the mesh has no nodes on {name}; choose another axis, sides free, or load none"
            )
    held = [Fixed(mesh.node_sets[name], k, name=name) for k, name in planes]
    if not rollers:
        held += _against_turning(mesh, axis, mesh.node_sets[near])
    if by_stress:
        faces = mesh.face_sets.get(far, np.zeros((0, 2), np.int64))
        if _other_bodies(mesh, held):
            raise CraftmeshError(
                f"load: a part of the body that nothing holds would be pulled off by a stress on {far}, as "
                "where the crack severs it; give a strain, which moves it"
            )
        return Load(tuple(held), pulled=(Traction(faces, float(magnitude), far),))
    low, high = (mesh.points[mesh.node_sets[name][0], axis] for name in (near, far))
    moved = Fixed(mesh.node_sets[far], axis, float(magnitude * (high - low)), far)
    return Load((*held, *_other_bodies(mesh, [*held, moved])), moved=(moved,))


def _other_bodies(mesh: TetMesh, supports: list[Fixed]) -> list[Fixed]:
    """Return what holds bodies that a crack has severed from the rest, as far as the supports do not."""
    held = [(fixed.nodes, fixed.axis) for fixed in supports]
    return [Fixed(np.array([node]), axis) for node, axis in lacking(mesh, held)]


def _against_turning(mesh: TetMesh, axis: int, nodes: np.ndarray) -> list[Fixed]:
    """Hold one of the nodes (k,) of a plane normal to `axis` in it, and the farthest against turning."""
    u, v = (other for other in range(3) if other != axis)
    points = mesh.points[nodes]
    corner = np.lexsort((points[:, v], points[:, u]))[0]
    far = np.lexsort((np.abs(points[:, v] - points[corner, v]), -points[:, u]))[0]
    at_corner, at_far = nodes[[corner]], nodes[[far]]
    return [Fixed(at_corner, u), Fixed(at_corner, v), Fixed(at_far, v)]

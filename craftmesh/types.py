"""The types that stages exchange: small, frozen, array-only."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final, NamedTuple, cast

import numpy as np

from craftmesh.arguments import Frozen, as_array, check_indices, refuse_others
from craftmesh.errors import CraftmeshError, rounded_values
from craftmesh.shown import Shown

# Kinds of voxels. A file may not say whether its voxels of label 0 are unindexed or void.
GRAIN: Final = "grain"
UNINDEXED: Final = "unindexed"
VOID: Final = "void"
# Facet kinds of a Surface. Box planes are numbered 1..6 in the order of BOX_PLANES.
# BORDER: a facet where a part was cut out of a mesh; no stage changes the facet or its corners.
INTERFACE = 0
CRACK = 7
BORDER = 8
BOX_PLANES = ("XMIN", "XMAX", "YMIN", "YMAX", "ZMIN", "ZMAX")
# Faces of a box in the order of BOX_PLANES: the axis normal to the face, and 1 for the upper face.
BOX_FACES = tuple((axis, upper) for axis in range(3) for upper in (0, 1))


def _extents(points: np.ndarray) -> str:
    """Return the bounding box of points (n, 3) as text with six digits; empty without points."""
    if not len(points):
        return ""
    low, high = rounded_values(np.stack([points.min(axis=0), points.max(axis=0)]))
    return f", from {low} to {high}"


class Crystal(NamedTuple):
    """The crystal of a phase as its file describes it; a field is "" where the file does not say.

    structure: cubic, hexagonal, tetragonal, orthorhombic, trigonal, monoclinic or triclinic; name: the
    material's name as written in the file.
    """

    structure: str = ""
    name: str = ""


@dataclass(frozen=True)
class Voxels(Frozen, Shown):
    """A labelled volume on a regular grid.

    labels (nx, ny, nz) int32: > 0 a grain id; 0 outside the material (connected to a face of the box); -k
    the enclosed void k. spacing, origin (3,) float64 in model units; the box is [origin, origin + shape *
    spacing]. orientations (g, 4) float64 or None: row = grain id, unit quaternion (w, x, y, z) of the
    active rotation that turns crystal axes into sample axes, NaN where unknown. phases (g,) int32 or None:
    row = grain id. crystals: phase -> Crystal, only for phases that the file describes; if phases is None,
    all grains have the crystal of phase 0. voxel_orientations (nx, ny, nz, 4) float32 or None: one
    quaternion per voxel, if these were kept. Raises CraftmeshError if shapes do not match or a spacing is
    <= 0.
    """

    labels: np.ndarray
    spacing: np.ndarray
    origin: np.ndarray
    orientations: np.ndarray | None = None
    phases: np.ndarray | None = None
    crystals: Mapping[int, Crystal] = field(default_factory=dict)
    voxel_orientations: np.ndarray | None = None

    def __post_init__(self) -> None:
        self._convert_mapping("crystals")
        self._convert("labels", np.int32, (None,) * 3)
        self._convert("spacing", float, (3,))
        self._convert("origin", float, (3,))
        if self.orientations is not None:
            self._convert("orientations", float, (None, 4), finite=False)
        if self.phases is not None:
            self._convert("phases", np.int32, (None,))
        if self.voxel_orientations is not None:
            self._convert("voxel_orientations", np.float32, (*self.labels.shape, 4), finite=False)
        if not (self.spacing > 0).all():
            raise CraftmeshError(f"spacing is {self.spacing.tolist()}; expected three numbers > 0")

    def __repr__(self) -> str:
        size = " x ".join(map(str, self.labels.shape))
        named = (name for name in ("orientations", "phases") if getattr(self, name) is not None)
        least, most = (self.labels.min(), self.labels.max()) if self.labels.size else (0, 0)
        spacing, grains = rounded_values(self.spacing), len(np.unique(self.labels[self.labels > 0]))
        parts = [size, f"spacing {spacing}", f"{grains} grains", f"labels {least} to {most}", *named]
        return f"Voxels({', '.join(parts)}{_extents(self.box)})"

    @property
    def box(self) -> np.ndarray:
        """(2, 3) lower and upper corner of the volume."""
        return np.stack([self.origin, self.origin + self.spacing * self.labels.shape])

    @property
    def faces(self) -> int:
        """Number of voxel faces between different labels, plus the faces of grain voxels on the box."""
        within = sum(np.count_nonzero(np.diff(self.labels, axis=axis)) for axis in range(3))
        on_box = sum(np.count_nonzero(self.labels.take((0, -1), axis=axis) > 0) for axis in range(3))
        return int(within + on_box)


@dataclass(frozen=True)
class Crack(Frozen, Shown):
    """A triangulated crack surface of one or several sheets, and its fronts.

    A sheet is a set of triangles connected across edges. It is single-valued over its best-fit plane, or
    cut along kinks into parts that are. Sheets are numbered in the order of their triangles. points (n, 3);
    triangles (m, 3) int32, oriented alike within a sheet. fronts: one int32 array of ordered point ids per
    front; a closed front repeats its first id at the end. Boundary edges that belong to no front are the
    crack mouth and lie on or outside the box.
    """

    points: np.ndarray
    triangles: np.ndarray
    fronts: tuple

    def __post_init__(self) -> None:
        self._convert("points", float, (None, 3))
        self._convert("triangles", np.int32, (None, 3))
        refuse_others("Crack.fronts", self.fronts, (tuple, list))
        fronts = tuple(as_array("Crack.fronts", front, np.int32, (None,)) for front in self.fronts)
        object.__setattr__(self, "fronts", fronts)
        check_indices("Crack.triangles", self.triangles, len(self.points))
        for front in fronts:
            check_indices("Crack.fronts", front, len(self.points))

    def __repr__(self) -> str:
        fronts = ", ".join(f"front of {len(front)} points" for front in self.fronts)
        counts = f"{len(self.triangles)} triangles, {len(self.points)} points"
        return f"Crack({counts}, {fronts or 'no front'}{_extents(self.points)})"

    @property
    def front_edges(self) -> np.ndarray:
        """(k, 2) int64: point ids of the edges of all fronts, front by front."""
        edges = [np.column_stack([front[:-1], front[1:]]) for front in self.fronts]
        return np.concatenate([np.zeros((0, 2), np.int64), *edges])


@dataclass(frozen=True)
class Surface(Frozen, Shown):
    """A conformal multi-material surface: each facet is stored once and separates two sides.

    points (n, 3) float64; facets (m, 3) int32; sides (m, 2) int32: labels behind and ahead of the facet's
    normal (right-hand rule), > 0 a grain, 0 outside, -k the void k. kind (m,) uint8: INTERFACE, 1..6 a
    plane of the box (corners exactly on it), or CRACK. A crack facet inside a grain has that grain on both
    sides. Invariant: without crack facets, the facets of each grain are closed and consistently oriented.
    """

    points: np.ndarray
    facets: np.ndarray
    sides: np.ndarray
    kind: np.ndarray

    def __post_init__(self) -> None:
        self._convert("points", float, (None, 3))
        self._convert("facets", np.int32, (None, 3))
        self._convert("sides", np.int32, (len(self.facets), 2))
        self._convert("kind", np.uint8, (len(self.facets),))
        check_indices("Surface.facets", self.facets, len(self.points))

    def __repr__(self) -> str:
        parts = [f"{len(self.facets)} facets", f"{len(self.points)} points", f"{len(self.grains)} grains"]
        voids, crack = np.unique(self.sides[self.sides < 0]), np.count_nonzero(self.kind == CRACK)
        parts += [f"{len(voids)} voids"] * bool(len(voids)) + [f"{crack} crack facets"] * bool(crack)
        return f"Surface({', '.join(parts)}{_extents(self.points)})"

    @classmethod
    def of_facets(
        cls,
        points: np.ndarray,
        facets: np.ndarray,
        sides: np.ndarray | tuple,
        crack: np.ndarray | None = None,
    ) -> "Surface":
        """Return the surface of the given facets, with kinds set here: INTERFACE, box planes, CRACK.

        sides (m, 2), or one pair for all facets: (1, 0) for one closed grain whose facet normals point
        outward. crack (m,) bool: mask of crack facets, none by default. A facet whose corners lie exactly
        on a plane of the facets' bounding box gets that plane as its kind if one of its sides is no grain.
        """
        facets = as_array("facets", facets, np.int32, (None, 3))
        if isinstance(sides, tuple) and len(sides) == 2 and not any(map(np.ndim, sides)):
            sides = np.tile(sides, (len(facets), 1))
        sides = cast(np.ndarray, sides)
        kind = np.full(len(facets), INTERFACE, np.uint8)
        surface = cls(points, facets, sides, kind)
        if len(kind):
            limits, is_open = surface.box.T.ravel(), (surface.sides <= 0).any(axis=1)
            for plane in range(len(BOX_PLANES)):
                on_plane = (surface.points[surface.facets, plane // 2] == limits[plane]).all(axis=1)
                kind[on_plane & is_open] = plane + 1
        if crack is not None:
            is_crack = np.asarray(crack)
            if is_crack.dtype != bool or is_crack.shape != kind.shape:
                raise CraftmeshError(
                    f"crack is an array {is_crack.shape} of {is_crack.dtype}; expected a boolean for "
                    f"each of {len(kind)} facets"
                )
            kind[is_crack] = CRACK
        return cls(points, facets, sides, kind)

    @property
    def box(self) -> np.ndarray:
        """(2, 3) lower and upper corner of the bounding box of the facets."""
        if not len(self.facets):
            raise CraftmeshError("the surface has no facets; give the facets of one or more grains")
        used = np.zeros(len(self.points), bool)
        used[self.facets] = True
        corners = self.points[used]
        return np.stack([corners.min(axis=0), corners.max(axis=0)])

    @property
    def grains(self) -> np.ndarray:
        """Sorted ids of the grains that have facets."""
        ids = np.unique(self.sides)
        return ids[ids > 0]


# Local nodes of the faces S1..S4, normals outward: three corners, then the mid node after each corner.
_OUTWARD = np.array([[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [2, 0, 3, 6, 7, 9]])


@dataclass(frozen=True)
class TetMesh(Frozen, Shown):
    """A conformal tetrahedral mesh with named sets; volumes and sets are not checked here but by `check`.

    points (n, 3) float64; tets (m, 4) or (m, 10) int64 in Abaqus order, positive volumes; grain (m,)
    int32. node_sets: name -> (k,) int64 node ids, order kept. face_sets: name -> (k, 2) int64 rows of
    (tet, face), faces 0..3 = Abaqus S1..S4 = nodes 123, 142, 243, 341. element_sets: name -> (k,) int64
    rows of `tets`.
    """

    points: np.ndarray
    tets: np.ndarray
    grain: np.ndarray
    node_sets: Mapping[str, np.ndarray] = field(default_factory=dict)
    face_sets: Mapping[str, np.ndarray] = field(default_factory=dict)
    element_sets: Mapping[str, np.ndarray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._convert("points", float, (None, 3))
        self._convert("tets", np.int64, (None, None))
        if self.tets.shape[1] not in (4, 10):
            raise CraftmeshError(f"TetMesh.tets has shape {self.tets.shape}; expected (n, 4) or (n, 10)")
        self._convert("grain", np.int32, (len(self.tets),))
        check_indices("TetMesh.tets", self.tets, len(self.points))
        for field_name, width in (("node_sets", ()), ("face_sets", (2,)), ("element_sets", ())):
            self._convert_mapping(field_name)
            sets = getattr(self, field_name).items()
            arrays = {name: as_array(f"set {name}", ids, np.int64, (None, *width)) for name, ids in sets}
            object.__setattr__(self, field_name, MappingProxyType(arrays))

    def __repr__(self) -> str:
        count, nodes = self.tets.shape
        parts = [f"{count} tets of {nodes} nodes", f"{len(self.points)} points"]
        parts += [f"{len(np.unique(self.grain))} grains", *self.face_sets]
        return f"TetMesh({', '.join(parts)}{_extents(self.points)})"

    @property
    def box(self) -> np.ndarray:
        """(2, 3) lower and upper corner of the box around the nodes."""
        return np.stack([self.points.min(axis=0), self.points.max(axis=0)])

    def outward_triangles(self, name: str) -> np.ndarray:
        """Return nodes (k, 3) of a face set, with mid nodes (k, 6); normals point out of the elements."""
        tets, faces = self.face_sets[name].T
        return self.tets[tets[:, None], _OUTWARD[faces, : 3 if self.tets.shape[1] == 4 else 6]]


@dataclass(frozen=True)
class GrainTets(Frozen):
    """The tetrahedra of one grain, on the points of the Surface that bounds it.

    nodes (k,) int64: ids of surface points; interior (p, 3) float64: points added inside; tets (n, 4)
    int64 of positive volume (not checked): id i < k is surface point nodes[i], id k + j is interior point
    j.
    """

    grain: int
    nodes: np.ndarray
    interior: np.ndarray
    tets: np.ndarray

    def __post_init__(self) -> None:
        object.__setattr__(self, "grain", int(as_array("GrainTets.grain", self.grain, np.int32, ())))
        self._convert("nodes", np.int64, (None,))
        self._convert("interior", float, (None, 3))
        self._convert("tets", np.int64, (None, 4))
        check_indices("GrainTets.tets", self.tets, len(self.nodes) + len(self.interior))

    def __repr__(self) -> str:
        counts = (
            f"{len(self.tets)} tets, {len(self.nodes)} surface points, {len(self.interior)} interior points"
        )
        return f"GrainTets(grain {self.grain}, {counts})"


@dataclass(frozen=True)
class Solution(Frozen):
    """A solver's results for a mesh: row i belongs to node i of the mesh, which is node i + 1 of the deck.

    displacement (n, 3) float64; reactions (n, 3) float64: the supports' forces on the body, 0 at free
    nodes. record: the solver's name and its figures by name (residual, iterations, ...), plain numbers and
    texts. contact (n, 3) float64: the forces of touching crack faces on each other; None if contact was
    not asked for or no crack faces would overlap. history: for a load in steps, arrays (k,) by
    name, one value per increment: `time`, and the nominal strain and stress of faces that move or are
    pulled, such as `ZMAX.z strain`. The fields above are those at the end of the history.
    """

    displacement: np.ndarray
    reactions: np.ndarray
    record: Mapping[str, str | int | float] = field(default_factory=dict)
    contact: np.ndarray | None = None
    history: Mapping[str, np.ndarray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._convert("displacement", float, (None, 3))
        self._convert("reactions", float, (len(self.displacement), 3))
        if self.contact is not None:
            self._convert("contact", float, (len(self.displacement), 3))
        self._convert_mapping("record")
        self._convert_mapping("history")
        history = {
            name: as_array(f"history {name}", rows, float, (None,), finite=False)
            for name, rows in self.history.items()
        }
        object.__setattr__(self, "history", MappingProxyType(history))

    def __repr__(self) -> str:
        parts = [f"{len(self.displacement)} nodes", *(f"{key} {one}" for key, one in self.record.items())]
        parts += ["contact"] * (self.contact is not None) + [f"history of {name}" for name in self.history]
        return f"Solution({', '.join(parts)})"

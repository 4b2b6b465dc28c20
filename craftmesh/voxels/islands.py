"""Islands: voids and grains that one grain encloses completely, found from the voxels.

The mesher needs a point inside each island; otherwise it fills the island with tetrahedra of the enclosing
grain. Source: the gradation paper, section 2.6. Enclosure is found from the topology, so clusters of
touching grains and islands inside islands are found too.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy

from craftmesh.arguments import Frozen
from craftmesh.errors import CraftmeshError
from craftmesh.types import GRAIN, VOID, Voxels
from craftmesh.voxels.voxel_graph import Pieces, find_pieces, shared_faces


@dataclass(frozen=True)
class Island(Frozen):
    """One region enclosed by the grain `host`, made of k pieces (connected components) of voxels.

    host: grain id. members: label of each piece, > 0 a grain, -k the void k; there are several if they
    touch each other. seeds (k, 3): a point inside each piece, in model coordinates. voxels: number in each
    piece. Pieces enclosed by a member are not listed here; they are islands of that member.
    """

    host: int
    members: tuple[int, ...]
    seeds: np.ndarray
    voxels: tuple[int, ...]

    def __post_init__(self) -> None:
        self._convert("seeds", float, (len(self.members), 3))

    def __repr__(self) -> str:
        return f"Island(host {self.host}, {len(self.members)} members, {sum(self.voxels)} voxels)"

    @property
    def kind(self) -> str:
        """VOID if all members are voids, else GRAIN."""
        return VOID if max(self.members) < 0 else GRAIN

    @property
    def seed(self) -> np.ndarray:
        """A point (3,) inside the island: the seed of its largest member, the first of equals."""
        return self.seeds[int(np.argmax(self.voxels))]


def find_islands(voxels: Voxels) -> tuple[Island, ...]:
    """Return the islands of a cleaned volume, ordered by host, then in scan order.

    A piece is enclosed by a host if every path across voxel faces from it to the outside of the box goes
    through the same piece of the host. A seed is the point farthest from its piece's boundary.
    """
    pieces = find_pieces(voxels.labels)
    enclosures = [(int(pieces.label[host]), members) for host, members in _enclosures(pieces)]
    enclosures = sorted(e for e in enclosures if e[0] > 0)
    if not enclosures:
        return ()
    windows = scipy.ndimage.find_objects(pieces.of + 1)
    islands = []
    for host, members in enclosures:
        seeds = np.array([_seed(pieces.of, m, windows[m], voxels) for m in members])
        seeds.flags.writeable = False
        labels = tuple(int(pieces.label[m]) for m in members)
        islands.append(Island(host, labels, seeds, tuple(int(pieces.voxels[m]) for m in members)))
    return tuple(islands)


def islands_as_json(islands: tuple[Island, ...]) -> dict:
    """Return islands as plain JSON values:

    {"islands": [{"host": 12, "kind": "void" | "grain",
                  "members": [{"label": -1, "seed": [x, y, z], "voxels": 33}, ...]}, ...]}
    with seeds in model units.
    """
    return {
        "islands": [
            {
                "host": island.host,
                "kind": island.kind,
                "members": [
                    {"label": label, "seed": seed, "voxels": voxels}
                    for label, seed, voxels in zip(island.members, island.seeds.tolist(), island.voxels)
                ],
            }
            for island in islands
        ]
    }


def islands_from_json(content: dict, place: str) -> tuple[Island, ...]:
    """Return islands from the content that `islands_as_json` made; raises CraftmeshError if it is wrong.

    place: the file, for the error message.
    """
    found = []
    try:
        for entry in content["islands"]:
            members = entry["members"]
            seeds = np.array([member["seed"] for member in members], float)
            if seeds.shape != (len(members), 3) or not members or not np.isfinite(seeds).all():
                raise ValueError(f"host {entry['host']} lacks a seed x, y, z for some member")
            seeds.flags.writeable = False
            labels, voxels = (tuple(int(one[key]) for one in members) for key in ("label", "voxels"))
            found.append(Island(int(entry["host"]), labels, seeds, voxels))
        return tuple(found)
    except (KeyError, TypeError, ValueError) as error:
        fault = f"no entry {error}" if isinstance(error, KeyError) else str(error)
        raise CraftmeshError(f"{place}: {fault}; give the islands .json of `craftmesh import`") from None


def _enclosures(pieces: Pieces) -> Iterator[tuple[int, list[int]]]:
    """Yield (host piece, enclosed pieces) for each region that one piece, the host, separates from outside.

    Such regions are the biconnected components of the graph of pieces that share faces. All paths from the
    outside into a component go through its host, so the host is its piece nearest to the outside.
    """
    from networkx import Graph, biconnected_components, single_source_shortest_path_length

    outside = len(pieces.label)
    graph = Graph(shared_faces(pieces.of, outside)[0].tolist())
    open_pieces = np.flatnonzero(pieces.touches_box | (pieces.label == 0)).tolist()
    graph.add_edges_from((piece, outside) for piece in open_pieces)
    away = single_source_shortest_path_length(graph, outside)
    for part in biconnected_components(graph):
        host = min(part, key=away.__getitem__)
        if host != outside:
            yield host, sorted(part - {host})


def _seed(of: np.ndarray, piece: int, window: tuple, voxels: Voxels) -> np.ndarray:
    """Return the point (3,) of a piece farthest from its boundary, in model coordinates.

    of (nx, ny, nz): piece of each voxel; window: slices around the piece. If several voxels are equally
    far, the point is their mean if that lies in one of them, else the centre of the voxel nearest to the
    mean. The centre of a 2 x 2 x 2 void is safer than the centre of one of its voxels.
    """
    inside = np.pad(of[window] == piece, 1)
    distance = scipy.ndimage.distance_transform_edt(inside, sampling=voxels.spacing)
    tied = np.argwhere(distance >= distance.max() * (1 - 1e-9))
    middle = tied.mean(axis=0)
    nearest = tied[np.argmin((((tied - middle) * voxels.spacing) ** 2).sum(axis=1))]
    at = np.floor(middle + 0.5).astype(np.int64)
    chosen = middle if (tied == at).all(axis=1).any() else nearest
    corner = np.array([part.start for part in window])
    return voxels.origin + (chosen - 1 + corner + 0.5) * voxels.spacing

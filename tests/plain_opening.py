"""How many nodes a mesh has once its crack is open, found slowly and plainly."""

from craftmesh.mesh.tet_connectivity import FACE_CORNERS


def slow_opening(tets, crack_faces):
    """Return the number of nodes after opening, by union of corners one face at a time."""
    boss = list(range(4 * len(tets)))

    def find(a):
        while boss[a] != a:
            a = boss[a]
        return a

    seen = {}
    for t, tet in enumerate(tets.tolist()):
        for corners in FACE_CORNERS.tolist():
            face = frozenset(tet[c] for c in corners)
            if face not in crack_faces:
                if face in seen:
                    for node in face:
                        other = seen[face]
                        boss[find(4 * t + tet.index(node))] = find(
                            4 * other + tets[other].tolist().index(node)
                        )
                seen[face] = t
    return len({find(a) for a in range(4 * len(tets))})

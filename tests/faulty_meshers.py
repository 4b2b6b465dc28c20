"""Meshers that fail at one grain, the one that lies in 1 <= x <= 2, and leave the others to TetGen."""

import os
import signal
import time

import numpy as np

from craftmesh.tetrahedra.meshers import TetGenMesher


class Faulty(TetGenMesher):
    """Calls `fail` for the grain in 1 <= x <= 2."""

    def mesh(self, points, facets, markers, interior_points, holes, switches):
        nodes, tets = super().mesh(points, facets, markers, interior_points, holes, switches)
        if points[:, 0].min() < 1 or points[:, 0].max() > 2:
            return nodes, tets
        return self.fail(nodes, tets, len(points), switches)


class Crashing(Faulty):
    def fail(self, nodes, tets, count, switches):
        os.kill(os.getpid(), signal.SIGSEGV)


class Hanging(Faulty):
    def fail(self, nodes, tets, count, switches):
        time.sleep(3600)


class Greedy(Faulty):
    def fail(self, nodes, tets, count, switches):
        np.ones(10**12)


class MovingNodes(Faulty):
    def fail(self, nodes, tets, count, switches):
        nodes = nodes.copy()
        nodes[:count] += 1e-12
        return nodes, tets


class LosingTets(Faulty):
    def fail(self, nodes, tets, count, switches):
        return nodes, tets[1:]


class OtherSurface(Faulty):
    """Meshes the convex hull, as a mesher does that does not keep the surface."""

    def fail(self, nodes, tets, count, switches):
        from scipy.spatial import Delaunay

        return nodes[:count], Delaunay(
            nodes[:count] + 0.01 * np.sin(np.arange(3 * count)).reshape(-1, 3)
        ).simplices


class CrashingAtQuality(Faulty):
    """Crashes as long as it is asked for quality."""

    def fail(self, nodes, tets, count, switches):
        if "q" in switches:
            os.kill(os.getpid(), signal.SIGSEGV)
        return nodes, tets

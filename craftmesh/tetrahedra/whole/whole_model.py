"""The whole model meshed in one call of pytetwild, with recovery of grains, box planes and crack."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version

import numpy as np
import scipy

from craftmesh.errors import CraftmeshError
from craftmesh.extras import extra
from craftmesh.processes.job import Failure, Job, Limits
from craftmesh.processes.worker import run_tasks
from craftmesh.progress import silent
from craftmesh.sizing.length_field import LocalSizing
from craftmesh.sizing.sizing import Lengths
from craftmesh.surface.connectivity import compact
from craftmesh.surface.labels import labels_at
from craftmesh.surface.measure import volume_drift, volumes_of
from craftmesh.tetrahedra.grain_surface import grain_surfaces
from craftmesh.tetrahedra.meshers import MesherRefusal
from craftmesh.tetrahedra.optimise_tets import optimise_tets
from craftmesh.tetrahedra.options import TetrahedralizeOptions
from craftmesh.tetrahedra.whole.crack_faces import recovery_of_crack, with_fins
from craftmesh.tetrahedra.whole.new_surface import model_of, move_onto_planes, settle_crack
from craftmesh.types import GrainTets, Surface

# Energy at which fTetWild stops improving the mesh; the regular tetrahedron has 3.
STOP_ENERGY = 10.0


@dataclass(frozen=True)
class TetWildTask:
    """Facets (m, 3) on points, to be meshed, with target edge lengths (b,) at points of a background mesh.

    envelope: largest distance of the mesh's facets from the given facets, in model units.
    """

    points: np.ndarray
    facets: np.ndarray
    background_points: np.ndarray
    background_tets: np.ndarray
    lengths: np.ndarray
    envelope: float


def tetwild(_: None, task: TetWildTask) -> tuple[np.ndarray, np.ndarray]:
    """Return (points, tets) that fill a box around the facets and conform to them within the envelope.

    This runs in a worker process. The tets (t, 4) int64 have volumes >= 0. The result does not tell which
    of their faces lie on the facets. pytetwild uses random numbers that cannot be seeded, so two meshes of
    the same input differ. Raises MesherRefusal if pytetwild makes no tets.
    """
    with extra("tetwild"):
        import pytetwild

    diagonal = np.linalg.norm(np.ptp(task.points, axis=0))
    points, tets = pytetwild.tetrahedralize(
        np.array(task.points, np.float64),
        np.array(task.facets, np.int32),
        edge_length_abs=float(task.lengths.max()),
        epsilon=float(task.envelope / diagonal),
        stop_energy=STOP_ENERGY,
        simplify=False,
        num_threads=1,
        disable_filtering=True,
        quiet=True,
        bg_vertices=np.array(task.background_points, np.float64),
        bg_tets=np.array(task.background_tets, np.int32),
        bg_values=np.array(task.lengths, np.float64),
    )
    if not len(tets):
        raise MesherRefusal("pytetwild made no tetrahedra")
    # its tets have the opposite orientation
    return np.asarray(points, float), np.asarray(tets, np.int64)[:, [0, 2, 1, 3]]


# Number of background lattice points along the longest side of the box.
LATTICE = 20
# Largest distance of faces from a box plane or crack that they belong to, relative to the envelope.
FACE_DISTANCE = 1.2
# Envelopes that are tried in turn, relative to the option `envelope`.
ENVELOPES = (1.0, 0.5)


def mesh_whole_model(
    surface: Surface,
    sizing: Lengths | None,
    options: TetrahedralizeOptions,
    progress: Callable[[float, str], None] = silent,
) -> tuple[Surface, list[GrainTets], dict]:
    """Return the surface of a new mesh of the whole model, the tets of each grain by id, and a report.

    This is for surfaces that surface-preserving meshers reject. Each grain boundary may move by up to
    `options.envelope` times the shortest target length, for both grains alike, so the mesh is conformal.
    Box planes are exact, and the crack's front is moved back onto the given front. sizing: `at(points)`
    gives target lengths; None uses the surface's edge lengths. Raises CraftmeshError if pytetwild fails, a
    grain is lost, or the crack cannot be found again.
    """
    with extra("tetwild"):
        version("pytetwild")  # its import takes seconds
    sizing = LocalSizing(surface.points, surface.facets) if sizing is None else sizing
    for factor in ENVELOPES:
        task = _task(surface, sizing, factor * options.envelope)
        progress(0.0, "meshing the whole model")
        points, tets, seconds = _run(task, options)
        progress(0.9, "finding the grains again")
        try:
            found, grain_tets, report = _found_again(surface, points, tets, task.envelope)
            break
        except CraftmeshError:
            # pytetwild uses random numbers, so the next mesh differs
            if factor == ENVELOPES[-1]:
                raise
    if options.optimise:
        grain_tets = _optimised(found, grain_tets, sizing)
    report |= {"tets": sum(len(grain.tets) for grain in grain_tets), "seconds": seconds}
    return found, grain_tets, report


def _found_again(
    surface: Surface, points: np.ndarray, tets: np.ndarray, envelope: float
) -> tuple[Surface, list[GrainTets], dict]:
    """Return the surface, the grains' tets and a report on their fit, from pytetwild's points and tets.

    envelope: in model units. Raises CraftmeshError if a grain or void is lost, if tets turn over on box
    planes, or if the crack is damaged.
    """
    reach = FACE_DISTANCE * envelope
    labels = labels_at(points[tets].mean(axis=1), surface.points, surface.facets, surface.sides)
    points, labels, on_planes = move_onto_planes(surface, points, tets, labels, reach)
    points, tets, labels = settle_crack(surface, points, tets, labels, reach)
    found, grain_tets = model_of(surface, points, tets, labels, reach)
    lost = np.setdiff1d(surface.sides, found.sides)
    if len(lost):
        name = f"grain {lost[-1]}" if lost[-1] > 0 else f"void {-lost[-1]}"
        raise CraftmeshError(
            f"{name} is lost in the mesh of the whole model ({len(lost)} in all); repair its surface or "
            "use a smaller envelope"
        )
    recovery = recovery_of_crack(surface, found)
    return found, grain_tets, {"envelope": envelope, **on_planes, **recovery, **_drift(surface, found)}


def _task(surface: Surface, sizing: Lengths, envelope: float) -> TetWildTask:
    points, facets, _ = compact(*with_fins(surface, sizing.at(surface.points)))
    low, high = points.min(axis=0), points.max(axis=0)
    step = (high - low).max() / LATTICE
    axes = [np.linspace(a - step, b + step, int((b - a) / step) + 3) for a, b in zip(low, high)]
    lattice = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    background = np.concatenate([np.unique(points, axis=0), lattice])
    lengths = sizing.at(background)
    shortest = float(lengths.min())
    tets = scipy.spatial.Delaunay(background).simplices
    return TetWildTask(points, facets, background, tets, lengths, envelope * shortest)


class _OneMesh:
    """A Listener of `run_tasks` for a job with one task; it stores the mesh and raises the failure."""

    def on_done(self, _: TetWildTask, value: tuple[np.ndarray, np.ndarray], seconds: float) -> None:
        self.mesh = (*value, seconds)

    def on_failure(self, _: TetWildTask, failure: Failure, __: float) -> None:
        raise CraftmeshError(
            f"pytetwild could not mesh the whole model: {failure.reason}; use larger sizes or a larger "
            "envelope, which are faster, or raise whole_time_limit and memory_limit"
        )


def _run(task: TetWildTask, options: TetrahedralizeOptions) -> tuple[np.ndarray, np.ndarray, float]:
    """Run pytetwild in a worker process under limits; return points, tets and seconds."""
    found = _OneMesh()
    job = Job(tetwild, None, Limits(options.whole_time_limit, options.memory_limit))
    run_tasks(job, [(1.0, task)], found, workers=1)
    return found.mesh


def _drift(before: Surface, after: Surface) -> dict:
    """Return the largest relative change of a grain's volume, and the grain's id, for the report."""
    volumes = [volumes_of(s) for s in (before, after)]
    drift = {grain: abs(part) for grain, part in volume_drift(*volumes).items()}
    worst = max(drift, key=lambda grain: drift[grain])
    return {"volume_drift_worst": drift[worst], "volume_drift_grain": worst}


def _optimised(surface: Surface, grain_tets: list[GrainTets], sizing: Lengths) -> list[GrainTets]:
    """Return the tets of each grain after `optimise_tets`, on the same surface."""
    result = []
    for one, bounds in zip(grain_tets, grain_surfaces(surface)):
        local = np.full(len(surface.points), -1, np.int64)
        local[one.nodes] = np.arange(len(one.nodes))
        points = np.concatenate([surface.points[one.nodes], one.interior])
        crack = local[bounds.nodes][bounds.facets[bounds.internal]]
        points, tets, _ = optimise_tets(points, one.tets, len(one.nodes), crack, sizing.at(points))
        result.append(GrainTets(one.grain, one.nodes, points[len(one.nodes) :], tets))
    return result

"""The inputs of the benchmarks: stitched surfaces with a crack or voids, made from files or generated."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT.parent / "shared" / "data"
PAPER = {"l_min": 0.5, "l0": 1.0, "l_max": 3.0, "r0": 8.0, "r1": 16.0, "exponent": 1.0}


@dataclass(frozen=True)
class Start:
    """What gradation starts from."""

    surface: object
    sizing: object
    islands: tuple


@dataclass(frozen=True)
class Case:
    """A named input: `build` makes its Start; `needs` is a file without which it is skipped."""

    build: Callable
    arguments: tuple
    needs: Path | None = None

    @property
    def missing(self) -> str:
        """A word on the file that is missing, or nothing."""
        return (
            f"{self.needs.name} is not in ../shared/data" if self.needs and not self.needs.exists() else ""
        )

    def start(self) -> Start:
        return self.build(*self.arguments)


def generated(edge: int, grains: int, **options) -> Start:
    """A generated cube with a semicircular crack on the face y = 0, of a quarter of the edge."""
    from craftmesh.voxels.generate import GenerateOptions, generate

    voxels = generate(GenerateOptions(shape=(edge,) * 3, grains=grains, seed=1, **options))
    return _cracked(voxels, _thumbnail(edge), PAPER)


def with_voids(edge: int, grains: int, voids: int, radius: float) -> Start:
    """A generated cube with voids, refined around their surfaces."""
    from craftmesh.remeshing.remesh import remesh
    from craftmesh.sizing.sizing import Sizing
    from craftmesh.voxels.generate import GenerateOptions, generate
    from craftmesh.voxels.islands import find_islands

    shape = (edge,) * 3
    voxels = generate(GenerateOptions(shape=shape, grains=grains, seed=1, voids=voids, void_radius=radius))
    surface, _ = remesh(voxels)
    sources = surface.points[np.unique(surface.facets[(surface.sides < 0).any(axis=1)])]
    sizing = Sizing(**(PAPER | {"r0": 4.0, "r1": 12.0}), sources=sources)
    return Start(surface, sizing, find_islands(voxels))


def stl_set(path: Path) -> Start:
    """A set of grain surfaces through the stitch door, with a semicircular crack on the face y = 0."""
    from craftmesh.stitching.stitch import stitch_grains
    from craftmesh.types import Voxels
    from craftmesh.voxels.islands import find_islands

    data = np.load(path)
    triangles, sides = data["triangles"], data["sides"]
    grains = []
    for grain in np.unique(sides[sides > 0]).tolist():
        outward = triangles[sides[:, 0] == grain], triangles[sides[:, 1] == grain][:, ::-1]
        grains.append((grain, data["points"], np.concatenate(outward)))
    surface, _ = stitch_grains(grains)
    voxels = Voxels(data["labels"], np.ones(3), np.zeros(3))
    edge = data["labels"].shape[0]
    return with_crack(surface, _thumbnail(edge), voxels.box, PAPER, find_islands(voxels))


def example(name: str, path: Path) -> Start:
    """The first increment of a configuration in examples/."""
    import yaml

    from craftmesh.voxels.clean import CleanOptions, clean
    from craftmesh.voxels.reading import read_voxels

    config = yaml.safe_load((ROOT / "examples" / name / "config.yaml").read_text())
    voxels, _ = clean(read_voxels(path), CleanOptions(**config.get("import", {})))
    (crack,) = config["cracks"].values()
    return _cracked(voxels, crack, config["sizing"] | {"exponent": 1.0})


def _thumbnail(edge: int) -> dict:
    return {"shape": "penny", "centre": (edge / 2, 0.0, edge / 2), "radius": edge / 4}


def _cracked(voxels, crack: dict, sizes: dict) -> Start:
    from craftmesh.remeshing.remesh import remesh
    from craftmesh.voxels.islands import find_islands

    surface, _ = remesh(voxels)
    return with_crack(surface, crack, voxels.box, sizes, find_islands(voxels))


def with_crack(surface, crack: dict, box, sizes: dict, islands: tuple) -> Start:
    from craftmesh.cracks.options import CrackOptions
    from craftmesh.cracks.series import prescribed_crack
    from craftmesh.insertion.insert import insert_crack
    from craftmesh.sizing.sizing import Sizing, densify

    made = prescribed_crack(box, CrackOptions(**crack))
    front = np.concatenate([densify(made.points[ids], sizes["l_min"] / 2) for ids in made.fronts])
    sizing = Sizing(**sizes, sources=front)
    return Start(insert_crack(surface, made, sizing)[0], sizing, islands)


TINY = Case(generated, (20, 6))
G26 = Case(stl_set, (DATA / "stl" / "g26.npz",), DATA / "stl" / "g26.npz")
G100 = Case(stl_set, (DATA / "stl" / "g100.npz",), DATA / "stl" / "g100.npz")
GRAINS_200 = Case(generated, (108, 200))
GRAINS_430 = Case(generated, (150, 430))
VOIDS = Case(with_voids, (64, 26, 30, 4.0))
_AL1050 = DATA / "al1050" / "al1050_labdct_109x103x64.npz"
_COPPER = DATA / "readers" / "copper_v7.dream3d"
_AL6XN = DATA / "al6xn" / "prisms_al6xn_68x64x46.npz"
AL6XN = Case(example, ("al6xn", _AL6XN), _AL6XN)
AL1050 = Case(example, ("al1050", _AL1050), _AL1050)
COPPER = Case(example, ("copper", _COPPER), _COPPER)

"""The library's calls and the command line give the same mesh, to the last byte."""

import numpy as np
import pytest
from edge_crack import write_edge_crack

import craftmesh as cm
from craftmesh import cli
from craftmesh.io.front_csv import rows_by_load
from craftmesh.io.npz import write_labels
from craftmesh.io.vtk import write_tets
from craftmesh.voxels.generate import generate
from craftmesh.voxels.options import GenerateOptions

SIZES = {"l_min": 0.8, "l0": 1.2, "l_max": 2.0, "r0": 3.0, "r1": 8.0}
GRAINS = {"shape": (14, 12, 12), "grains": 4, "seed": 1}


def disc(x, height=6.03, radius=2.6):
    return {"shape": "penny", "centre": (x, 6.05, height), "normal": (0.0, 0.0, 1.0), "radius": radius}


CASES = {
    # .001 l_min apart: one crack with a neck
    "two discs": (GRAINS, [disc(4.0), disc(4.0 + 2 * 2.6 + 0.0008)]),
    "an edge crack": (GRAINS, [disc(0.0, radius=5.0)]),
    "discs that cross": (GRAINS, [disc(6.0), disc(7.0) | {"normal": (0.0, 1.0, 0.3)}]),
    "no crack": (GRAINS, []),
    "a void": (GRAINS | {"voids": 1}, [disc(0.0, radius=4.0)]),
}


def flags(options):
    for key, value in options.items():
        yield f"--{key.replace('_', '-')}"
        yield from map(str, value if isinstance(value, tuple) else (value,))


def command_line(voxels, cracks):
    """Return the bytes of volume.vtu, made stage by stage in the present folder."""
    write_labels("labels.npz", voxels)
    sizes = list(flags(SIZES))
    run("remesh", "labels.npz", "-o", "plain.vtp")
    source = []
    if cracks:
        first, *others = (list(flags(one)) for one in cracks)
        more = [word for other in others for word in ("--and", *other)]
        lengths = flags({key: SIZES[key] for key in ("l_min", "l0")})
        run("crack", "labels.npz", *first, *lengths, "-o", "crack.vtp", *more)
        source = ["--crack", "crack.vtp"]
    run("size", "plain.vtp", *source, *sizes, "-o", "sizing.npz")
    sizing = ["--sizing", "sizing.npz"]
    run("stitch", "plain.vtp", *source, *sizing, "-o", "surface.vtp")
    run("gradate", "surface.vtp", *source, *sizing, "-o", "gradated.vtp")
    run("tetrahedralize", "gradated.vtp", *source, *sizing, "-o", "volume.vtu")
    return open("volume.vtu", "rb").read()


def run(*words):
    assert cli.main(list(words)) == 0


def library(voxels, cracks):
    surface, _ = cm.remesh(voxels)
    made = [cm.prescribed_crack(voxels.box, cm.CrackOptions(**one)) for one in cracks]
    crack = cm.prepare_crack(made, voxels.box, SIZES["l_min"]) if made else None
    sizing = cm.sizing_around(surface, cm.Defects(crack), cm.SizingOptions(**SIZES))
    if crack is not None:
        surface, _ = cm.insert_crack(surface, crack, sizing)
    surface, _ = cm.gradate(surface, sizing, crack=crack)
    filled, _ = cm.mesh_volume(surface, sizing)
    write_tets("library.vtu", cm.assemble(filled.surface, filled.grain_tets, crack)[0])
    return open("library.vtu", "rb").read()


@pytest.mark.sampled(5)
@pytest.mark.parametrize("case", CASES)
def test_the_library_gives_the_command_lines_bytes(case, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    grains, cracks = CASES[case]
    voxels = generate(GenerateOptions(**grains))
    assert np.any(voxels.labels < 0) == ("voids" in grains)
    assert command_line(voxels, cracks) == library(voxels, cracks)


def edge_crack(folder):
    """Return the mesh of a box with an edge crack, its crack, its voxels and the columns of its fronts."""
    write_edge_crack(folder, (8, 3, 8))
    body, crack = cm.read_tets(folder / "volume.vtu"), cm.read_crack(folder / "crack.vtp")
    voxels = cm.Voxels(np.ones((8, 3, 8), int), np.ones(3), np.zeros(3))
    return body, crack, voxels, cm.front_frames(body).columns()


FACES = ("ZMIN.z=fixed", "ZMIN.x=fixed", "ZMIN.y=fixed", "up/ZMAX.z=stress:50", "aside/ZMAX.x=stress:9")
LOADS = {
    "one load": ({"magnitude": 1e-3, "quarter_points": True}, {"extension": 1.0}),
    "a cycle": (
        {"faces": FACES, "combine": ("peak=up:1,aside:1", "valley=up:0.2")},
        {"cycle": ("peak", "valley"), "extension": 1.0, "law": "power", "coefficient": 1e-9},
    ),
}


@pytest.mark.parametrize("load", LOADS)
def test_solution_intensities_and_the_next_crack_have_the_command_lines_bytes(load, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    body, crack, voxels, frames = edge_crack(tmp_path)
    write_labels("labels.npz", voxels)
    cm.write_front("front.csv", frames)
    loaded, growth = LOADS[load]
    loaded |= {"material": ("isotropic:70000,0.33",)}
    given = list(flags({k: v for k, v in loaded.items() if v is not True}))
    given += ["--quarter-points"] * ("quarter_points" in loaded)
    run("solve", "volume.vtu", "-o", "solution.npz", *given)
    goes = ["--crack", "crack.vtp", "--json", "fracture.json", *flags(growth)]
    run("fracture", "volume.vtu", "solution.npz", "-o", "sif.csv", *goes, *given)
    crack_files = ["crack.vtp", "sif.csv", "front.csv", "--volume", "labels.npz"]
    run("grow", *crack_files, "-o", "grown.vtp", "--step", "step.csv", "--report", "grow.json")

    model, _ = cm.elastic_model(body, cm.ModelOptions(**loaded))
    solutions, _ = cm.solve_model(model)
    found, _ = cm.stress_intensities(model, solutions)
    ways, _ = cm.front_extensions(crack, model, solutions, found, cm.GrowthOptions(**growth))
    grown, _ = cm.grow_crack(crack, voxels, ways, frames)
    cm.write_solutions("own.npz", solutions)
    columns = {name: one.columns() for name, one in found.items()}
    columns[next(iter(columns))] = ways
    cm.write_front("own.csv", rows_by_load(columns))
    cm.write_crack("own.vtp", grown.crack)
    cm.write_front("own_step.csv", cm.step_columns(grown.step))
    assert len(grown.crack.points) > len(crack.points) and np.ptp(ways["K_I"]) > 0
    files = {
        "solution.npz": "own.npz",
        "sif.csv": "own.csv",
        "grown.vtp": "own.vtp",
        "step.csv": "own_step.csv",
    }
    for made, own in files.items():
        assert (tmp_path / made).read_bytes() == (tmp_path / own).read_bytes(), made


def test_what_does_not_fit_is_refused_in_one_line(tmp_path):
    body, crack, voxels, frames = edge_crack(tmp_path)
    model, _ = cm.elastic_model(body, cm.ModelOptions(material=("isotropic:70000,0.33",)))
    with pytest.raises(cm.CraftmeshError, match="solver is calculix, which is not run here"):
        cm.solve_model(model, cm.SolveOptions(solver="calculix"))
    with pytest.raises(cm.CraftmeshError, match="no column extension; give the columns of"):
        cm.grow_crack(crack, voxels, frames, frames)
    ways = {"node": frames["node"] + 1, "kink_angle": 0 * frames["s"], "extension": 0 * frames["s"]}
    with pytest.raises(cm.CraftmeshError, match="name different nodes"):
        cm.grow_crack(crack, voxels, ways, frames)
    with pytest.raises(cm.CraftmeshError, match="no load cycles to continue"):
        cm.counted_front({"cycles": 1.0})

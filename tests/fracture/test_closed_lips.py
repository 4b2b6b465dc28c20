"""K of lips that press on each other: none of mode I; K of the shear, less what friction bears."""

from dataclasses import replace

import numpy as np
import pytest
from near_fields import POISSON, YOUNG
from warped_cracks import disc_crack

from craftmesh.cli import main
from craftmesh.fracture.lip_pressure import contact_tractions
from craftmesh.fracture.options import FractureOptions
from craftmesh.fracture.parameters import fracture_parameters
from craftmesh.io.front_csv import read_front
from craftmesh.io.stage_npz import read_solution
from craftmesh.io.vtk import write_tets
from craftmesh.mechanics.lips import LipField, loaded_lips
from craftmesh.mechanics.load import Fixed, Load
from craftmesh.mechanics.materials import parse_materials
from craftmesh.mechanics.model import elastic_model
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.mesh.lips import lip_pairs
from craftmesh.solve.options import SolveOptions
from craftmesh.solve.solve import solve
from craftmesh.types import BOX_PLANES

MATERIAL = f"isotropic:{YOUNG},{POISSON}"
# 1 / YOUNG times 1 is the strain of pressure 1; shear comes with it
STRAIN = np.array([[POISSON, 0, 0.5], [0, POISSON, 0.2], [0.5, 0.2, -1]]) / YOUNG


@pytest.fixture(scope="module")
def model():
    """A penny of radius 1 whose box is pressed and sheared as a body without it would be."""
    options = ModelOptions(material=(MATERIAL,), load="none", quarter_points=True)
    model, _ = elastic_model(disc_crack(5, 3, 4), options)
    mesh = model.mesh
    outer = np.unique(np.concatenate([mesh.node_sets[name] for name in BOX_PLANES]))
    moved = mesh.points[outer] @ STRAIN
    return replace(model, load=Load(tuple(Fixed(outer, axis, moved[:, axis]) for axis in range(3))))


def parameters(model, solution):
    within = FractureOptions(radius=2.5)  # the box ends three edges from the front
    return fracture_parameters(
        model.mesh,
        solution.displacement,
        model.grains,
        model.stiffness(),
        within,
        contact=solution.contact,
    )


def test_a_closed_penny_has_no_k_of_mode_i_and_that_of_the_shear(model):
    closed, overlapping = (
        solve(model, SolveOptions(tolerance=1e-5, contact=contact))[0] for contact in (True, False)
    )
    pressure = np.linalg.norm(contact_tractions(model.mesh, closed.contact).traction, axis=2)
    # 0.5 % where the pressure alone acts; forces beside the front, where lips slide, err by some 2 %
    assert np.abs(pressure - 1).max() < 0.1 and abs(pressure.mean() - 1) < 0.005
    found, _ = parameters(model, closed)
    other, _ = parameters(model, overlapping)
    open_k = 2 / np.sqrt(np.pi)
    assert np.abs(found.K_I).max() < 0.01 * open_k  # measured 0.3 %; without the lips' term 70 %
    assert other.K_I.max() < -0.6 * open_k  # the box is small
    sheared = np.abs([other.K_II, other.K_III]).max()
    for mode in ("K_II", "K_III"):
        assert np.abs(getattr(found, mode) - getattr(other, mode)).max() < 0.005 * sheared
    assert all("closed" in words for words in found.flags) and np.isnan(found.T).all()
    assert np.abs(np.sqrt(found.J / found.G) - 1).max() < 0.02


def test_friction_leaves_k_of_the_shear_that_it_does_not_bear(model):
    """Linear in the shear: the pressure is 1, and so is friction's coefficient times it."""
    exact = SolveOptions(tolerance=1e-5)
    shear = np.hypot(0.5, 0.2) / (1 + POISSON)
    free, _ = parameters(model, solve(model, exact)[0])
    slid, _ = parameters(model, solve(replace(model, lip_friction=0.2), exact)[0])
    sheared = np.abs([free.K_II, free.K_III]).max()
    for mode in ("K_I", "K_II", "K_III"):
        left = (1 - 0.2 / shear) * getattr(free, mode)
        assert np.abs(getattr(slid, mode) - left).max() < 0.01 * sheared  # measured 0.3 %
    assert np.abs(np.sqrt(slid.J / slid.G) - 1).max() < 0.03  # 1.1 % without friction, of a larger root
    stuck, _ = parameters(model, solve(replace(model, lip_friction=0.5), exact)[0])
    assert np.abs([stuck.K_I, stuck.K_II, stuck.K_III]).max() < 0.01 * sheared  # measured 0.6 %


def test_lips_slide_where_friction_is_less_than_the_shear(model):
    """The pressure is 0.2 + 1.6 r^2 on a disc, so that lips stick beyond a radius, with a slip known in it.

    Poisson's ratio is 0: the slip is that of an opening (Sneddon 1946). It ends where K of a smaller penny
    under the shear less the friction is 0.
    """
    friction, low, rise, radius = 0.5, 0.2, 1.6, 0.5
    driving = friction * rise * 2 / 3 * radius**2
    mesh, young = model.mesh, 1.0
    stress = np.array(
        [[0, 0, friction * low + driving], [0, 0, 0], [friction * low + driving, 0, -low - rise]]
    )
    grid = np.linspace(-1, 1, 81)
    x, y = (part.ravel() for part in np.meshgrid(grid, grid))
    x, y = (part[np.hypot(x, y) <= 1 + 1e-9] for part in (x, y))
    field = LipField(np.column_stack([x, y, 0 * x]), rise * (1 - x * x - y * y), np.zeros((len(x), 3)))
    held = [
        replace(part, displacement=(mesh.points[part.nodes] @ stress)[:, part.axis])
        for part in model.load.held
    ]
    soft = parse_materials((f"isotropic:{young},0",))
    lips = Load(tuple(held), (), loaded_lips(mesh, 0.0, (), field))
    solution, report = solve(
        replace(model, load=lips, materials=soft, lip_friction=friction), SolveOptions(tolerance=1e-7)
    )
    assert 0 < report["contact_sticking"] < report["contact_closed"] == report["contact_pairs"]
    a, b = lip_pairs(mesh).nodes.T
    slip, off = solution.displacement[a] - solution.displacement[b], np.hypot(*mesh.points[a, :2].T)
    slides = np.linalg.norm(slip, axis=1) > 1e-6 * np.abs(slip).max()
    edge = 0.2
    assert off[slides].max() < radius + edge / 2 and off[~slides].min() > radius - edge / 2
    middle = 16 / (3 * np.pi) * driving * radius / young
    # measured 0.935 of it: 3 % in an infinite body, and the box holds it back
    assert slip[off < 0.01, 0].mean() == pytest.approx(middle, rel=0.1)


def test_the_verb_takes_the_forces_of_contact_from_the_solution(tmp_path, model):
    write_tets(tmp_path / "volume.vtu", disc_crack(2, 2, 2))
    flags = ("--material", MATERIAL, "--quarter-points", "--magnitude", "-1e-3")
    volume, solution, sif = (str(tmp_path / name) for name in ("volume.vtu", "u.npz", "sif.csv"))
    assert main(["solve", volume, "-o", solution, *flags]) == 0
    found = read_solution(solution)
    assert found.record["contact_closed"] == found.record["contact_pairs"] and found.contact.any()
    assert main(["fracture", volume, solution, "-o", sif, *flags]) == 0
    columns = read_front(sif)
    opened = YOUNG * 1e-3 * 2 / np.sqrt(np.pi)
    assert np.abs(columns["K_I"]).max() < 0.02 * opened and np.isnan(columns["T"]).all()

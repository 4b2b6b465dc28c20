"""Find J, K_I, K_II, K_III and T along the crack's fronts: from the displacements of a solved mesh.

Give the options with which it was solved: a field that does not fit them is refused, unless load is none.
Planes that the load holds, moves or pulls count as loaded where a front ends on them.
"""

import argparse
from pathlib import Path

import numpy as np

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.microstructure import add_microstructure, orientations_and_phases
from craftmesh.commands.stage_io import add_output, existing, tell, write_json
from craftmesh.errors import CraftmeshError
from craftmesh.fracture.options import FractureOptions
from craftmesh.fracture.parameters import FrontParameters, fracture_parameters
from craftmesh.growth.extension import NEAR_FIELD, KinksAndExtensions, crack_radius, kinks_and_extensions
from craftmesh.growth.gate import AVERAGED, Evidence, doubts
from craftmesh.growth.options import GrowthOptions
from craftmesh.io.front_csv import has_word, write_front
from craftmesh.io.solution import read_solution
from craftmesh.io.vtk import read_crack, read_tets
from craftmesh.mechanics.load import Load
from craftmesh.mechanics.model import ElasticModel, elastic_model
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.mechanics.near_field import in_axes
from craftmesh.mesh.front_frames import front_frames
from craftmesh.solve.foreign import foreign_solution
from craftmesh.solve.options import EXTERNAL
from craftmesh.solve.problem import DECK_RULE, problem_of
from craftmesh.solve.solve import FULL_RULE
from craftmesh.solve.stress import mean_stress
from craftmesh.types import Solution

# A field of the same model is as far out of balance as before, but for rounding; without the quarter points
# of a penny it was 8e-2.
MORE, ROUNDING = 10.0, 1e-10
TOLD = ("front", "nodes", "radius", "largest_K", "largest_spread", "root_of_J_over_G", "flagged")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("volume", type=Path, help="mesh .vtu")
    parser.add_argument("solution", type=Path, help="solution .npz of `craftmesh solve`")
    add_output(parser, "parameters .csv, one row per front node")
    parser.add_argument(
        "--json", type=Path, metavar="FILE", help="what was integrated, and how far to trust it"
    )
    add_microstructure(parser)
    parser.add_argument(
        "--crack",
        type=Path,
        metavar="FILE",
        help="crack surface .vtp: find how it grows as well, columns kink_angle and extension",
    )
    add_options(parser, FractureOptions, ModelOptions, GrowthOptions)


def run(arguments: argparse.Namespace) -> None:
    known = orientations_and_phases(arguments)
    model, _ = elastic_model(read_tets(arguments.volume), options_from(arguments, ModelOptions), **known)
    solution = read_solution(existing(arguments.solution))
    displacement = solution.displacement
    if displacement.shape != model.mesh.points.shape:
        raise CraftmeshError(
            f"{arguments.solution}: has {len(displacement)} nodes, the mesh {len(model.mesh.points)}; give "
            "the solution of this mesh, and the same element"
        )
    if model.load is not None:
        _check_field(model, solution, str(arguments.solution))
    parameters, report = fracture_parameters(
        model.mesh,
        displacement,
        model.grains,
        model.stiffness(),
        options_from(arguments, FractureOptions),
        loaded_planes(model.load),
        solution.contact,
    )
    columns = parameters.columns()
    if arguments.crack:
        radius = crack_radius(read_crack(existing(arguments.crack)), model.mesh.box)
        options = options_from(arguments, GrowthOptions)
        crystals = local_stiffness(model) if options.criterion == NEAR_FIELD else None
        stress = mean_stress(model, displacement)
        doubt = evidence(parameters, solution, stress, radius)
        growth = kinks_and_extensions(intensities(parameters), radius, options, doubt, crystals)
        columns |= growth_columns(growth) | {"flags": columns.pop("flags")}
        report["growth"] = {"radius": radius, "stress": stress, "cycles": growth.cycles}
    write_front(arguments.output, columns)
    if arguments.json:
        write_json(arguments.json, report)
    for front in report["fronts"]:
        tell({key: front[key] for key in TOLD}, None)


def intensities(parameters: FrontParameters) -> np.ndarray:
    """Return K_I, K_II, K_III (n, 3) of the front nodes."""
    return np.column_stack([parameters.K_I, parameters.K_II, parameters.K_III])


def evidence(parameters: FrontParameters, solution: Solution, stress: float, radius: float) -> Evidence:
    """Return how far K of the front nodes says something, in a body of that mean stress."""
    doubt = doubts(intensities(parameters), parameters.front, parameters.spread, stress, radius)
    trusted = ~has_word(parameters.flags, AVERAGED)
    return Evidence(parameters.points, doubt, trusted, "contact_closed" in solution.record)


def local_stiffness(model: ElasticModel) -> np.ndarray:
    """Return the stiffness (n, 6, 6) of the grain along the front at its nodes, in their local axes."""
    frames = front_frames(model.mesh)
    axes = np.stack([frames.binormal, frames.normal, frames.tangent], axis=1)
    grain = model.stiffness()[np.searchsorted(model.grains, frames.grain)]
    return np.concatenate([in_axes(own, turn[None]) for own, turn in zip(grain, axes)])


def growth_columns(growth: KinksAndExtensions) -> dict[str, np.ndarray]:
    """Return the columns of sif.csv that say how a front goes on; kink angles in degrees."""
    angle = np.degrees(growth.kink_angle)
    way = {"kink_angle": angle, "extension": growth.extension, "driving": growth.driving}
    return way | {"stays": growth.stays}


def _check_field(model: ElasticModel, solution: Solution, source: str) -> None:
    """Raise CraftmeshError for a field that is not in balance as it was when it was found."""
    numbers = np.arange(1, len(solution.displacement) + 1)
    foreign_solution(model, numbers, solution.displacement, EXTERNAL, source, solution.contact)
    recorded = float(solution.record.get("residual", np.inf))
    residual = min(
        problem_of(model, rule).balance(solution.displacement, solution.contact)[2]
        for rule in (DECK_RULE, FULL_RULE)
    )
    if residual > MORE * max(recorded, ROUNDING):
        raise CraftmeshError(
            f"{source}: the field leaves {residual:.1e} of the forces out of balance here, and left "
            f"{recorded:.1e} when it was found; give the options with which it was solved (quarter_points?)"
        )


def loaded_planes(load: Load | None) -> set[str]:
    """Return the names of the planes that a load holds, moves or pulls."""
    if load is None:
        return set()
    names = {part.name for part in (*load.held, *load.moved)} | {part.name for part in load.pulled}
    return names - {""}

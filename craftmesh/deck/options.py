"""Options of a deck besides its model: files, user materials, steps, contact and output."""

from dataclasses import dataclass
from typing import Literal

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.cohesive import parse_cohesive
from craftmesh.mechanics.faces import RESIDUAL, check_supports, parse_faces
from craftmesh.mechanics.history import RAMP, LoadStep, parse_steps
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.options import option

FLAT, PARTS, MESH = "flat", "parts", "mesh"
# Options that concern only the file; solvers that run on the deck do not offer them.
OF_THE_FILE = ("includes", "style")


@dataclass(frozen=True)
class DeckOptions(ModelOptions):
    """Options of a deck: its model's, then files, user materials, load history, contact and output."""

    includes: bool = option(
        False, "write nodes, elements and sets to MODEL_mesh.inp, which the deck MODEL.inp includes"
    )
    style: Literal["flat", "parts", "mesh"] = option(
        FLAT,
        "flat, for Abaqus and CalculiX; parts, for Abaqus: the body is a part, with instance BODY-1 in an "
        "assembly; mesh: only nodes, elements and sets",
    )
    user_material: str = option(
        "",
        "template of a user subroutine's material, which the deck has instead of material (K and builtin "
        "keep that): angles, huang, oxford, single_crystal (CalculiX), or your own .yaml",
    )
    orientations: Literal["grain", "element"] = option(
        "grain",
        "axes of sections: the grain's mean, or for each element the axes of its nearest voxel, if "
        "import kept them (voxel_orientations); builtin and K take the mean",
    )
    steps: tuple[str, ...] = option(
        (),
        "history of the load, instead of one step, as a list of steps: ramp:LEVEL, triangle:PEAK or "
        "sine:PEAK, levels times the load, then separated by commas time= of a ramp or a cycle (1), "
        "increments= in it at least (20), and for cycles R= valley over peak (0) and cycles= (1); NAME/ in "
        "front of a step names its load case or sum",
    )
    lip_contact: bool = option(False, "contact between the lips of each crack")
    cohesive: tuple[str, ...] = option(
        (),
        "zero-thickness cohesive elements on grain boundaries, only in the deck, for Abaqus: "
        "SCOPE:stiffness=K,... or SCOPE:none; SCOPE all, low_angle (under 15 degrees) or two grains as "
        "3-7, the narrowest counts; other values than stiffness (normal to the boundary): shear_stiffness "
        "(along it), strength, shear_strength, energy, shear_energy, eta of the mix, viscosity. A crack in "
        "a boundary has none",
    )
    output_every: int = option(1, "increments from one field output to the next, with steps", at_least=1)
    restart_every: int = option(0, "increments from one restart record to the next, 0: none", at_least=0)

    def __post_init__(self) -> None:
        """Raise CraftmeshError for values out of bounds and for values that do not fit each other."""
        super().__post_init__()
        parse_cohesive(self.cohesive)
        if self.includes and self.style == MESH:
            raise CraftmeshError("includes is true, but style mesh writes only the mesh; keep one of them")
        if self.history and not self.is_loaded:
            raise CraftmeshError("steps are given, but nothing is loaded; give a load, faces or a pressure")
        if self.orientations == "element" and self.strains_grains:
            raise CraftmeshError(
                "orientations is element, but an eigenstrain is given, which needs grain axes; keep one"
            )
        if self.user_material and self.strains_grains:
            raise CraftmeshError(
                f"user_material is {self.user_material!r}, but an eigenstrain is given, which its deck "
                "cannot hold; keep one"
            )

    @property
    def history(self) -> tuple[LoadStep, ...]:
        """The steps of the load, empty if it acts in a single step.

        A loaded model with a user material or lip contact gets a ramp if no steps are given. Raises
        CraftmeshError if that model has load cases, and for invalid steps.
        """
        names = list(dict.fromkeys([*self.cases, *(one.name for one in self.combinations)]))
        not_linear = (self.user_material or self.lip_contact) and self.is_loaded and not self.steps
        if not_linear and names:
            raise CraftmeshError(
                f"{'user_material' if self.user_material else 'lip_contact'} takes the load in increments, "
                f"but there are load cases; give steps, such as {names[0]}/ramp:1"
            )
        steps = parse_steps(("ramp:1",) if not_linear else self.steps, names)
        sums = {one.name: one.factors for one in self.combinations}
        if self.residual_stress and any(step.kind != RAMP or step.level != 1 for step in steps):
            raise CraftmeshError(
                f"residual_stress is {self.residual_stress!r}, but steps scale it with their load; "
                f"give only steps CASE/ramp:1, such as {RESIDUAL}/ramp:1 and then {names[0]}/ramp:1"
            )
        cases = [case for step in steps for case in sums.get(step.load, {step.load: 1.0})]
        check_supports("steps: the history has", dict.fromkeys(cases), parse_faces(self.faces))
        return steps

"""What a deck holds beside its model: files, user materials, steps, contact and output."""

from dataclasses import dataclass

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.cohesive import parse_cohesive
from craftmesh.mechanics.faces import check_supports, parse_faces
from craftmesh.mechanics.history import LoadStep, parse_steps
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.options import option

FLAT, PARTS, MESH = "flat", "parts", "mesh"
# Options of the file alone, which solvers that are run on the deck do not ask for.
OF_THE_FILE = ("includes", "style")


@dataclass(frozen=True)
class DeckOptions(ModelOptions):
    """What the deck holds beside the mesh: element type, materials, load and its history."""

    includes: bool = option(
        False, "write nodes, elements and sets to MODEL_mesh.inp, which the deck MODEL.inp includes"
    )
    style: str = option(
        FLAT,
        "flat, for Abaqus and CalculiX; parts, for Abaqus: the body a part, and its instance BODY-1 in an "
        "assembly; mesh: nodes, elements and sets alone",
        choices=(FLAT, PARTS, MESH),
    )
    user_material: str = option(
        "",
        "template of a user subroutine's material in place of material, which K and builtin keep: angles, "
        "huang, oxford, single_crystal (CalculiX), or a .yaml of one's own",
    )
    orientations: str = option(
        "grain",
        "axes of sections: the grain's mean, or of each element that of its nearest voxel, where import "
        "kept them (voxel_orientations); builtin and K take the mean",
        choices=("grain", "element"),
    )
    steps: tuple[str, ...] = option(
        (),
        "history of the load in place of one step at once, step after step: ramp:LEVEL, triangle:PEAK or "
        "sine:PEAK, levels times the load, then with commas time= of a ramp or a cycle (1), increments= of "
        "it at least (20), and for cycles R= valley over peak (0) and cycles= (1); NAME/ before a step: "
        "of that load case or sum",
    )
    lip_contact: bool = option(False, "lips of cracks press on each other, without friction")
    cohesive: tuple[str, ...] = option(
        (),
        "zero-thickness cohesive elements on grain boundaries, in the deck alone, for Abaqus: "
        "SCOPE:stiffness=K,... or SCOPE:none; SCOPE all, low_angle (under 15 degrees) or two grains as "
        "3-7, the narrowest counts; beside stiffness, across a boundary: shear_stiffness along it, "
        "strength, shear_strength, energy, shear_energy, eta of the mix, viscosity. A crack in a "
        "boundary has none",
    )
    output_every: int = option(
        1, "increments from one output of fields to the next, with steps", at_least=1
    )
    restart_every: int = option(0, "increments from one restart record to the next, 0: none", at_least=0)

    def __post_init__(self) -> None:
        """Raise CraftmeshError for values out of bounds, and for those that do not fit each other."""
        super().__post_init__()
        parse_cohesive(self.cohesive)
        if self.includes and self.style == MESH:
            raise CraftmeshError("includes is true, and style mesh is the mesh alone; keep one of them")
        if self.history and not self.is_loaded:
            raise CraftmeshError(
                "steps are given, and nothing is loaded; expected a load, faces or a pressure"
            )
        if self.orientations == "element" and self.strains_grains:
            raise CraftmeshError(
                "orientations is element, and there is an eigenstrain, which is of grains; keep one"
            )
        if self.user_material and self.strains_grains:
            raise CraftmeshError(
                f"user_material is {self.user_material!r}, and there is an eigenstrain, of which its deck "
                "does not know; keep one"
            )

    @property
    def history(self) -> tuple[LoadStep, ...]:
        """The steps of the load, none where it comes at once; what is not linear takes increments."""
        names = list(dict.fromkeys([*self.cases, *(one.name for one in self.combinations)]))
        not_linear = (self.user_material or self.lip_contact) and self.is_loaded and not self.steps
        if not_linear and names:
            raise CraftmeshError(
                f"{'user_material' if self.user_material else 'lip_contact'} takes the load in increments, "
                f"and there are load cases; expected steps, as {names[0]}/ramp:1"
            )
        steps = parse_steps(("ramp:1",) if not_linear else self.steps, names)
        sums = {one.name: one.factors for one in self.combinations}
        cases = [case for step in steps for case in sums.get(step.load, {step.load: 1.0})]
        check_supports("steps", dict.fromkeys(cases), parse_faces(self.faces))
        return steps

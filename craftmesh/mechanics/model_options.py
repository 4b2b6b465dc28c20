"""Options of the finite-element model, which the deck, the solver and K share."""

from dataclasses import dataclass
from typing import Literal

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.eigenstrains import parse_eigenstrains
from craftmesh.mechanics.faces import RESIDUAL, Combination, check_supports, combinations_of, parse_faces
from craftmesh.options import Options, option

# names of load cases that keys make; LOAD: of everything else, if only the residual stress has a name
LIP_PRESSURE, EIGENSTRAIN, LOAD = "lip_pressure", "eigenstrain", "load"
PLATES = "plates"
# Largest coefficient of friction that was tried, on 23 pressed blocks and 7 other bodies.
MOST_FRICTION = 2.0


@dataclass(frozen=True)
class ModelOptions(Options):
    """Options of a finite-element model: element type, materials, loads and supports."""

    element: Literal["C3D4", "C3D10"] = option("C3D10", "element type")
    material: tuple[str, ...] = option(
        ("isotropic:70000,0.33",),
        "KIND:CONSTANTS for all phases or PHASE=KIND:CONSTANTS each; kinds and constants: isotropic E,nu; "
        "cubic c11,c12,c44; hexagonal c11,c12,c13,c33,c44, c along the crystal's z; anisotropic 21 "
        "constants D1111,D1122,D2222,... in Abaqus' order",
    )
    load: Literal["strain", "stress", "plates", "none"] = option(
        "strain",
        "what magnitude is; plates: the strain, and in the deck (which is then for Abaqus only) two rigid "
        "frictionless plates compress the body",
    )
    magnitude: float = option(1e-3, "strain, or stress in the materials' unit; tension is positive")
    axis: Literal["x", "y", "z"] = option("z", "axis of the tension")
    sides: Literal["free", "rollers"] = option(
        "free",
        "minimum planes of the other two axes: free, with the body held against rotation and sliding at "
        "two nodes, or on rollers (planes of symmetry, in which a crack is mirrored)",
    )
    faces: tuple[str, ...] = option(
        (),
        "loads and supports of faces, instead of load, magnitude, axis and sides: FACE.AXIS=fixed, "
        "FACE.AXIS=strain:VALUE (displacement over the box's length normal to the face) or "
        "FACE.AXIS=stress:VALUE; FACE is XMIN to ZMAX, AXIS its normal or one in it. The same value on "
        "opposite faces is a uniform tension or shear; unnamed components are free. AXIS=stress:VALUE "
        "fixes the near face and pulls the far one. CASE/ in front puts a row into that load case only",
    )
    combine: tuple[str, ...] = option(
        (),
        "sums of load cases, NAME=CASE:FACTOR,CASE:FACTOR,...; K is found for the sums, or for each case",
    )
    lip_pressure: float = option(
        0.0,
        "pressure on the lips (crack faces), in the materials' unit; positive opens the cracks; added to "
        "the load, or alone with load none; with load cases it is a case of its own, lip_pressure",
    )
    lip_traction: tuple[float, ...] = option(
        (),
        "traction on lips A along x, y, z, in the materials' unit, with its opposite on lips B; added to "
        "lip_pressure",
    )
    lip_field: str = option(
        "",
        "csv of a field on the lips: columns x,y,z, and pressure, or tx,ty,tz as in lip_traction, or all; "
        "added to both options",
    )
    lip_friction: float = option(
        0.0,
        "Coulomb's coefficient of friction of lips that touch, with builtin, and in decks with lip_contact",
        at_least=0,
        at_most=MOST_FRICTION,
    )
    residual_stress: str = option(
        "",
        "csv or .vtu of a stress in the body without its crack, in the materials' unit: columns of x,y,z, "
        "those along which it varies, and of sxx,syy,szz,sxy,sxz,syz, those that are not 0. It acts in "
        "each load case and sum, growth does not scale it, and alone it is the load case residual_stress",
    )
    eigenstrain: tuple[str, ...] = option(
        (),
        "strains that grains would have if nothing held them, such as thermal expansion times temperature "
        "change: KIND:VALUES for all phases or PHASE=KIND:VALUES each, 0 in the others; kinds and "
        "values: isotropic one; in crystal axes orthotropic 11,22,33; anisotropic 11,22,33,12,13,23. "
        "With load cases it is a case of its own, eigenstrain",
    )
    eigenstrain_file: str = option(
        "",
        "csv of the grains' eigenstrains, instead of eigenstrain: columns grain, and e along all axes, or "
        "e11,e22,e33,e12,e13,e23 in sample axes",
    )
    temperature: str = option(
        "",
        "csv or .vtu of the temperature change in the body. A csv has the column temperature, and those of "
        "x,y,z along which the temperature varies. Eigenstrains are then per degree, such as a coefficient "
        "of thermal expansion. The temperature is continuous across cracks",
    )
    quarter_points: bool | None = option(
        None,
        "move the mid nodes of C3D10 next to the crack front to a quarter of their edges; none: only in "
        "cases whose cracks grow",
    )
    scale: float = option(
        1.0,
        "lengths in the deck over the model's: 1000 writes a model in m in mm; stresses and moduli keep "
        "their unit; displacements from other solvers are converted back",
        above=0,
    )

    def __post_init__(self) -> None:
        """Raise CraftmeshError for values out of bounds and for values that do not fit each other."""
        super().__post_init__()
        if self.quarter_points and self.element != "C3D10":
            raise CraftmeshError(
                f"quarter_points is true, but {self.element} has no mid nodes; expected element C3D10"
            )
        if len(self.lip_traction) not in (0, 3):
            raise CraftmeshError(
                f"lip_traction has {len(self.lip_traction)} numbers; expected 3, along x, y and z"
            )
        if self.eigenstrain and self.eigenstrain_file:
            raise CraftmeshError(
                f"eigenstrain_file is {self.eigenstrain_file!r}, but eigenstrain is given too; keep one"
            )
        if self.temperature and not self.strains_grains:
            raise CraftmeshError(
                f"temperature is {self.temperature!r}, but no grain expands; give the coefficient of "
                "thermal expansion as eigenstrain, such as isotropic:1.2e-5, or as eigenstrain_file"
            )
        if self.residual_stress and self.has_plates:
            raise CraftmeshError(
                f"residual_stress is {self.residual_stress!r}, but load is plates, which has no load "
                "cases; give load strain"
            )
        _ = self.combinations
        parse_eigenstrains(self.eigenstrain)
        if self.has_plates and not self.magnitude < 0:
            raise CraftmeshError(
                f"magnitude is {self.magnitude:g}, but plates only compress; give a negative strain "
                "such as -0.001"
            )
        if self.load in ("strain", PLATES) and abs(self.magnitude) > 1:
            raise CraftmeshError(
                f"magnitude is {self.magnitude:g}, a strain over 1 in size; give a "
                "small one such as 0.001, or load stress"
            )

    @property
    def cases(self) -> tuple[str, ...]:
        """Names of the load cases, empty if there is a single load.

        If rows of faces name cases, lip loads and eigenstrains are a further case each. The residual stress
        always is a case of its own; if the faces name no cases, all other loads are then the case LOAD.
        """
        own = {LIP_PRESSURE: self.loads_lips, EIGENSTRAIN: self.strains_grains}
        named = (*self.named, *(name for name, given in own.items() if self.named and given))
        if not self.residual_stress:
            return named
        return (*(named or (LOAD,) * self.has_other_load), RESIDUAL)

    @property
    def named(self) -> tuple[str, ...]:
        """Names of the load cases of faces."""
        return tuple(dict.fromkeys(row.case for row in parse_faces(self.faces) if row.case))

    @property
    def combinations(self) -> tuple[Combination, ...]:
        """The sums of load cases in the option `combine`; without any, each load case by itself.

        With a residual stress each sum has it, by default once; the last sum is the residual stress alone.
        """
        rows = parse_faces(self.faces)
        found = combinations_of(rows, self.cases, self.combine)
        if not self.residual_stress:
            return found
        check_supports(f"{RESIDUAL}: it acts with", self.cases, rows)
        alone = Combination(RESIDUAL, {RESIDUAL: 1.0})
        loaded = [one for one in found if one.name != RESIDUAL]
        return (*(one._replace(factors={RESIDUAL: 1.0, **one.factors}) for one in loaded), alone)

    @property
    def has_plates(self) -> bool:
        """Whether the load is the compression by two rigid plates."""
        return self.load == PLATES and not self.faces

    @property
    def is_loaded(self) -> bool:
        """Whether the options have any load, eigenstrain or residual stress that is not 0."""
        return self.has_other_load or bool(self.residual_stress)

    @property
    def has_other_load(self) -> bool:
        """Whether the options have any load or eigenstrain that is not 0, besides the residual stress."""
        if self.faces:
            strained = any(row.value for row in parse_faces(self.faces))
        else:
            strained = self.load != "none" and bool(self.magnitude)
        return strained or self.strains_grains or self.loads_lips

    @property
    def strains_grains(self) -> bool:
        """Whether grains have eigenstrains."""
        given = parse_eigenstrains(self.eigenstrain).values()
        return any(strain.any() for strain in given) or bool(self.eigenstrain_file)

    @property
    def loads_lips(self) -> bool:
        """Whether any load acts on the lips."""
        return bool(self.lip_pressure) or any(self.lip_traction) or bool(self.lip_field)

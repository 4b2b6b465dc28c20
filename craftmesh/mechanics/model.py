"""The finite-element model of a mesh: its elements, the materials of its grains, and its load.

The deck writes the model and the solver solves it. What both must agree on is determined here, once.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from craftmesh.arguments import typed
from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.crystals import misfits
from craftmesh.mechanics.eigenstrains import axes_of, eigenstrains_of_grains, given_strains, is_even
from craftmesh.mechanics.faces import RESIDUAL, Combination, parse_faces, rows_of
from craftmesh.mechanics.lips import LipField, loaded_lips
from craftmesh.mechanics.load import Load, combined, load_on, near_planes, tension
from craftmesh.mechanics.materials import Material, parse_materials, phases_of_grains, turned
from craftmesh.mechanics.model_options import EIGENSTRAIN, LIP_PRESSURE, ModelOptions
from craftmesh.mechanics.orientation import normalized, quaternion_to_matrix
from craftmesh.mechanics.point_fields import PointField
from craftmesh.mechanics.residual_stress import residual_lips
from craftmesh.mesh.second_order import as_elements
from craftmesh.surface.side_data import notes_on_ids
from craftmesh.types import Crystal, TetMesh


@dataclass(frozen=True, eq=False)
class ElasticModel:
    """A linear elastic body in finite elements, with its supports and loads.

    mesh: with the nodes of `element`, C3D4 or C3D10; grains (g,): ids that occur, ascending; axes: by grain
    of known orientation, the sample components (6,) of its crystal axes [100] and [010]; materials: by
    phase, None for all; phase_of: key in `materials` by grain; load: the only load or the first case, None
    if no load is asked for; own_strain (g, 3, 3): eigenstrain of each grain in its own axes; scale: lengths
    in the deck over lengths here. cases: loads by load case; combinations: the sums of cases that are asked
    for. element_axes (m, 6): like axes, for single elements; only the deck uses them, and a row of NaN
    means the axes of the grain. lip_friction: coefficient of friction of lips (crack faces) that touch.
    temperature (n,): factor of the eigenstrains at the nodes, None for 1 everywhere; elements interpolate
    it with their shape functions.
    """

    mesh: TetMesh
    element: str
    grains: np.ndarray
    axes: Mapping[int, np.ndarray]
    materials: Mapping[int | None, Material]
    phase_of: Mapping[int, int | None]
    load: Load | None
    own_strain: np.ndarray
    scale: float = 1.0
    cases: Mapping[str, Load] = field(default_factory=dict)
    combinations: tuple[Combination, ...] = ()
    element_axes: np.ndarray | None = None
    lip_friction: float = 0.0
    temperature: np.ndarray | None = None

    def under(self, one: Combination) -> "ElasticModel":
        """Return the model whose load is one combination of its load cases."""
        load = combined([(factor, self.cases[case]) for case, factor in one.factors.items()])
        return replace(self, load=load)

    def by_load(self) -> dict[str, "ElasticModel"]:
        """Return the model under each combination of load cases, by name; {"": self} without any."""
        return {one.name: self.under(one) for one in self.combinations} or {"": self}

    def loads(self, names: Iterable[str]) -> dict[str, Load]:
        """Return the loads of the cases and combinations `names`; the name "" is the only load.

        Names whose load is None are left out; an unknown name raises KeyError.
        """
        sums = {name: one.load for name, one in self.by_load().items()}
        known = {"": self.load, **self.cases, **sums}
        return {name: load for name in names if (load := known[name]) is not None}

    def in_unit_of_deck(self) -> "ElasticModel":
        """Return the model in the deck's unit of length: lengths and displacements times `scale`.

        Stresses, moduli and strains stay the same, so forces become scale^2 times as large.
        """
        if self.scale == 1:
            return self
        mesh = replace(self.mesh, points=self.scale * self.mesh.points)
        load = None if self.load is None else self.load.with_lengths(self.scale)
        cases = {name: one.with_lengths(self.scale) for name, one in self.cases.items()}
        return replace(self, mesh=mesh, load=load, scale=1.0, cases=cases)

    def on_copies(self, mesh: TetMesh) -> "ElasticModel":
        """Return the model on a mesh with the same elements, some of whose nodes are copies."""
        if self.temperature is None:
            return replace(self, mesh=mesh)
        temperature = np.zeros(len(mesh.points))
        temperature[mesh.tets] = self.temperature[self.mesh.tets]
        return replace(self, mesh=mesh, temperature=temperature)

    def stiffness(self) -> np.ndarray:
        """Return the stiffness (g, 6, 6) of each grain in sample axes, in the form of `Material.stiffness`.

        Grains of one isotropic material get bitwise equal values, because they are not rotated.
        """
        found = []
        for grain in self.grains.tolist():
            material = self.materials[self.phase_of[grain]]
            stiffness = material.stiffness()
            if grain in self.axes and material.kind != "isotropic":
                stiffness = turned(stiffness, self.own_axes(grain))
            found.append(stiffness)
        return np.array(found).reshape(-1, 6, 6)

    def own_axes(self, grain: int) -> np.ndarray:
        """Return the axes of a grain as columns (3, 3): its crystal's, or the sample's where unknown."""
        return axes_of(grain, self.axes)

    def eigenstrain(self) -> np.ndarray:
        """Return the eigenstrain (g, 3, 3) of each grain in sample axes, times the load's factor `heat`.

        It is 0 without a load, and times `temperature` where that is given. Grains of one isotropic strain
        get bitwise equal values.
        """
        heat = 0.0 if self.load is None else self.load.heat
        turns = [self.own_axes(grain) for grain in self.grains.tolist()]
        pairs = zip(self.own_strain, turns)
        found = [own if is_even(own) else turn @ own @ turn.T for own, turn in pairs]
        return heat * np.array(found).reshape(-1, 3, 3)


@typed
def elastic_model(
    mesh: TetMesh,
    options: ModelOptions,
    orientations: np.ndarray | None = None,
    phases: np.ndarray | None = None,
    crystals: Mapping[int, Crystal] = MappingProxyType({}),
    lip_field: LipField | None = None,
    grain_strains: Mapping[int, np.ndarray] | None = None,
    residual_stress: PointField | None = None,
    temperature: PointField | None = None,
) -> tuple[ElasticModel, dict]:
    """Return the model of a 4- or 10-node mesh, and a report.

    The report has the element type, the numbers of nodes, elements and grains, and of moved and refused
    quarter points if they are asked for. It has `notes` if a material lacks the symmetry of its crystal or
    if ids of grain_strains are no grains.

    orientations (n, 4): row = grain id, unit quaternion (w, x, y, z) of the active rotation from crystal to
    sample axes, NaN unknown; phases (n,): row = grain id; crystals: by phase; lip_field, grain_strains,
    residual_stress, temperature: the content of the files that options lip_field, eigenstrain_file,
    residual_stress and temperature name, strains (3, 3) by grain in sample axes. Raises CraftmeshError if a
    grain whose material or eigenstrain is not isotropic has no orientation, a phase has no material, the
    element type does not fit the mesh, a file that options name is not passed, the load cannot act on the
    mesh, or a strain by the temperature is over 1.
    """
    _check_held(
        options,
        lip_field=lip_field,
        eigenstrain_file=grain_strains,
        residual_stress=residual_stress,
        temperature=temperature,
    )
    mesh, report = as_elements(mesh, options.element, bool(options.quarter_points))
    grains = np.unique(mesh.grain)
    axes = _crystal_axes(grains, orientations)
    materials = parse_materials(options.material)
    phase_of = phases_of_grains(grains, materials, phases)
    _check_oriented(axes, materials, phase_of)
    notes = misfits(phase_of, materials, phases, crystals)
    if grain_strains is None:
        own_strain = eigenstrains_of_grains(options.eigenstrain, grains, phases, axes)
    else:
        notes += notes_on_ids("eigenstrain_file", grain_strains, grains.tolist())
        own_strain = given_strains(grain_strains, grains, axes)
    named = [name for name in options.cases if name != RESIDUAL]
    cases = {name: _load(mesh, options, lip_field, name if options.named else "") for name in named}
    load = next(iter(cases.values())) if cases else _load(mesh, options, lip_field)
    if residual_stress is not None:
        _check_unit(residual_stress, materials)
        cases[RESIDUAL] = _of_residual(mesh, options, residual_stress, load)
    model = ElasticModel(
        mesh,
        options.element,
        grains,
        axes,
        materials,
        phase_of,
        load,
        own_strain,
        options.scale,
        {name: one for name, one in cases.items() if one is not None},
        options.combinations,
        lip_friction=options.lip_friction,
        temperature=None if temperature is None else _at_nodes(temperature, mesh, own_strain),
    )
    return model, report | {"grains": len(grains)} | ({"notes": notes} if notes else {})


def _at_nodes(temperature: PointField, mesh: TetMesh, strain: np.ndarray) -> np.ndarray:
    """Return the temperature (n,) of a mesh's nodes; strain (g, 3, 3): of the grains at temperature 1."""
    needed = "in the whole body, 0 where its temperature does not change"
    found = temperature.at(mesh.points, "temperature", mesh.box, needed)[:, 0]
    size = np.abs(found).max() * np.abs(strain).max()
    if size > 1:
        raise CraftmeshError(
            f"temperature: a change of {np.abs(found).max():g} with an eigenstrain of "
            f"{np.abs(strain).max():g} is a strain of {size:g}, over 1; give eigenstrains per degree"
        )
    return found


def _check_unit(field: PointField, materials: Mapping[int | None, Material]) -> None:
    """Raise CraftmeshError if a stress is larger than all stiffnesses."""
    most = max(float(material.stiffness().max()) for material in materials.values())
    size = float(np.abs(field.values).max())
    if size > most:
        raise CraftmeshError(
            f"residual_stress: a stress of {size:g} is larger than the stiffness {most:g} of the "
            "materials; give both in one unit"
        )


def _of_residual(mesh: TetMesh, options: ModelOptions, field: PointField, load: Load | None) -> Load:
    """Return the load of a residual stress, with the supports of `load`, or of load none without one."""
    if load is None:
        planes = near_planes(range(3) if options.sides == "rollers" else ())
        return load_on(mesh, planes, lips=residual_lips(mesh, field))
    return replace(combined([(0.0, load)]), pulled=residual_lips(mesh, field))


def _check_held(options: ModelOptions, **held: object) -> None:
    """Raise CraftmeshError if options name a file whose content was not passed."""
    for name, content in held.items():
        if getattr(options, name) and content is None:
            raise CraftmeshError(
                f"{name} is {getattr(options, name)!r}, but the model reads no file; pass its content"
            )


def _crystal_axes(grains: np.ndarray, orientations: np.ndarray | None) -> dict[int, np.ndarray]:
    if orientations is None:
        return {}
    grains = grains[grains < len(orientations)]
    matrices = quaternion_to_matrix(normalized(orientations[grains]))
    return {
        grain: matrix[:, :2].T.ravel()
        for grain, matrix in zip(grains.tolist(), matrices)
        if np.isfinite(matrix).all()
    }


def _check_oriented(
    axes: Mapping[int, np.ndarray],
    materials: Mapping[int | None, Material],
    phase_of: Mapping[int, int | None],
) -> None:
    unoriented = [g for g in phase_of if g not in axes and materials[phase_of[g]].kind != "isotropic"]
    if unoriented:
        kind = materials[phase_of[unoriented[0]]].kind
        raise CraftmeshError(
            f"material: {kind} needs an orientation per grain, but {len(unoriented)} have none (the first: "
            f"{unoriented[0]}); give orientations with the microstructure, or an isotropic material"
        )


def _load(mesh: TetMesh, options: ModelOptions, field: LipField | None, case: str = "") -> Load | None:
    """Return the load of a case, or with case "" the only load; None if there is no load.

    With load cases, lip loads and eigenstrains act only in the cases LIP_PRESSURE and EIGENSTRAIN.
    """
    heat = float(options.strains_grains and case in ("", EIGENSTRAIN))
    on_lips = options.loads_lips and case in ("", LIP_PRESSURE)
    lips = loaded_lips(mesh, options.lip_pressure, options.lip_traction, field) if on_lips else ()
    rollers = options.sides == "rollers"
    if options.faces:
        return load_on(mesh, rows_of(parse_faces(options.faces), case), lips=lips, heat=heat)
    if options.load == "none" and not lips and not heat:
        return None
    if options.load == "none":
        return load_on(mesh, near_planes(range(3) if rollers else ()), lips=lips, heat=heat)
    axis, by_stress = "xyz".index(options.axis), options.load == "stress"
    load = tension(mesh, axis, options.magnitude, by_stress, rollers, lips)
    return replace(load, heat=heat)

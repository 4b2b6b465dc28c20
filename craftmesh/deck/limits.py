"""What Abaqus and CalculiX take of a deck: lines, names, numbers, and the least Jacobian."""

import re

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.model import ElasticModel
from craftmesh.mesh.integration import smallest_jacobians

LINE_LIMIT = 256  # characters, in Abaqus
NAME_LIMIT = 80  # characters, in both
ROW_LIMIT = 16  # entries of a set, in both
NUMBER_LIMIT = 999_999_999  # of nodes and elements, in Abaqus
# CalculiX takes less for no Jacobian at all, whatever the unit of length. With 2.20 elements of 100 nm in
# metres (1e-21) end in an error each; those of 1 um (1e-18) are solved.
LEAST_JACOBIAN = 1e-20
_UNIT_STEP = 1000  # from a unit of length to the next: m, mm, um


def name_fault(name: str) -> str:
    """Return what keeps the solvers from reading a set's or a material's name, "" where nothing does.

    Abaqus wants a letter first. CalculiX takes a set named 7 within another one for the element 7, and
    leaves blanks out of all names.
    """
    if len(name) > NAME_LIMIT:
        return f"has over {NAME_LIMIT} characters"
    if not re.fullmatch("[A-Za-z][A-Za-z0-9_-]*", name):
        return "is none of a letter and then letters, digits, _ and -"
    return ""


def check_writable(model: ElasticModel) -> None:
    """Raise CraftmeshError for names and numbers that the deck of a model cannot have.

    Names of one kind that differ in capitals alone are one set to the solvers.
    """
    mesh = model.mesh
    surfaces = {name: np.unique(faces[:, 1]) + 1 for name, faces in mesh.face_sets.items() if len(faces)}
    names = {
        "node set": ["NALL", *(name for name, nodes in mesh.node_sets.items() if len(nodes))],
        "surface": list(surfaces),
        "element set": ["EALL", *(f"GRAIN_{grain}" for grain in model.grains)]
        + [f"{name}_S{side}" for name, sides in surfaces.items() for side in sides],
    }
    for kind, given in names.items():
        seen: set[str] = set()
        for name in given:
            fault = name_fault(name)
            if name.upper() in seen:
                fault = "is there twice to the solvers, to which capitals are the same as small letters"
            if fault:
                raise CraftmeshError(f"deck: the {kind} {name[:40]!r} {fault}; give the mesh another name")
            seen.add(name.upper())
    for kind, count in (("nodes", len(mesh.points)), ("elements", len(mesh.tets))):
        if count > NUMBER_LIMIT:
            raise CraftmeshError(f"deck: {count} {kind}; Abaqus takes {NUMBER_LIMIT}: mesh more coarsely")


def too_small_sentence(least: np.ndarray) -> str:
    """Return a sentence where positive Jacobians (m,) are too small for CalculiX, "" where none is."""
    small = least[(least > 0) & (least < LEAST_JACOBIAN)]
    if not len(small):
        return ""
    factor = _UNIT_STEP
    while small.min() * float(factor) ** 3 < LEAST_JACOBIAN:
        factor *= _UNIT_STEP
    return (
        f"{len(small)} elements have a Jacobian under {LEAST_JACOBIAN:g} (the least {small.min():.1e}), "
        f"which CalculiX takes for none; write the deck in a unit of length {factor} times smaller "
        "(inp.scale)"
    )


def deck_warning(model: ElasticModel) -> str:
    """Return in a sentence why CalculiX would refuse the deck of a sound model, "" where it would not."""
    return too_small_sentence(smallest_jacobians(model.mesh.points, model.mesh.tets) * model.scale**3)

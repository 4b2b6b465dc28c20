"""Limits of Abaqus and CalculiX on decks: lines, names, numbers, and the smallest Jacobian."""

import re

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.model import ElasticModel
from craftmesh.mesh.integration import smallest_jacobians

LINE_LIMIT = 256  # largest number of characters of a line, in Abaqus
NAME_LIMIT = 80  # largest number of characters of a name, in both programs
ROW_LIMIT = 16  # largest number of entries in a row of a set, in both programs
NUMBER_LIMIT = 999_999_999  # largest number of a node or element, in Abaqus
# Smallest Jacobian: CalculiX treats smaller ones as 0, whatever the unit of length. In version 2.20
# elements of 100 nm in metres (1e-21) end in an error; elements of 1 um (1e-18) are solved.
LEAST_JACOBIAN = 1e-20
_UNIT_STEP = 1000  # ratio of a unit of length to the next: m, mm, um


def name_fault(name: str) -> str:
    """Return the reason why solvers cannot read a set's or material's name, "" if they can.

    Abaqus wants a letter first. CalculiX takes a set named 7 within another set for the element 7, and
    removes blanks from all names.
    """
    if len(name) > NAME_LIMIT:
        return f"has over {NAME_LIMIT} characters"
    if not re.fullmatch("[A-Za-z][A-Za-z0-9_-]*", name):
        return "is not a letter followed by letters, digits, _ and -"
    return ""


def check_writable(model: ElasticModel) -> None:
    """Raise CraftmeshError for names of sets that solvers cannot read, and for too many nodes or elements.

    Names of one kind that differ only in case count as duplicate, because they are the same to the solvers.
    """
    mesh = model.mesh
    surfaces = {name: np.unique(faces[:, 1]) + 1 for name, faces in mesh.face_sets.items() if len(faces)}
    names = {
        "node set": ["NALL", *(name for name, nodes in mesh.node_sets.items() if len(nodes))],
        "surface": list(surfaces),
        "element set": ["EALL", *(f"GRAIN_{grain}" for grain in model.grains)]
        + [f"{name}_S{side}" for name, sides in surfaces.items() for side in sides]
        + [name for name, rows in mesh.element_sets.items() if len(rows)],
    }
    for kind, given in names.items():
        seen: set[str] = set()
        for name in given:
            fault = name_fault(name)
            if name.upper() in seen:
                fault = "is duplicate to the solvers, which do not distinguish upper and lower case"
            if fault:
                raise CraftmeshError(f"deck: the {kind} {name[:40]!r} {fault}; rename it in the mesh")
            seen.add(name.upper())
    for kind, count in (("nodes", len(mesh.points)), ("elements", len(mesh.tets))):
        if count > NUMBER_LIMIT:
            raise CraftmeshError(f"deck: {count} {kind} exceed Abaqus' {NUMBER_LIMIT}; mesh more coarsely")


def too_small_sentence(least: np.ndarray) -> str:
    """Return a sentence if some positive Jacobians (m,) are too small for CalculiX, else ""."""
    small = least[(least > 0) & (least < LEAST_JACOBIAN)]
    if not len(small):
        return ""
    factor = _UNIT_STEP
    while small.min() * float(factor) ** 3 < LEAST_JACOBIAN:
        factor *= _UNIT_STEP
    return (
        f"{len(small)} elements have a Jacobian under {LEAST_JACOBIAN:g} (the smallest {small.min():.1e}), "
        f"which CalculiX treats as 0; write the deck in a unit of length {factor} times smaller "
        "(inp.scale)"
    )


def deck_warning(model: ElasticModel) -> str:
    """Return a sentence if Jacobians in the deck's unit would be too small for CalculiX, else ""."""
    return too_small_sentence(smallest_jacobians(model.mesh.points, model.mesh.tets) * model.scale**3)

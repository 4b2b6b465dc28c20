"""Checks of an input deck from its text alone: syntax, references and element shapes."""

import os
import re
from collections.abc import Sequence

import numpy as np
import scipy

from craftmesh.deck.check_references import reference_faults
from craftmesh.deck.includes import Block, DeckText, read_blocks, read_deck_text
from craftmesh.deck.limits import (
    LINE_LIMIT,
    NUMBER_LIMIT,
    ROW_LIMIT,
    name_fault,
    too_small_sentence,
)
from craftmesh.deck.parts import OUTPUT
from craftmesh.errors import CraftmeshError
from craftmesh.mesh.integration import smallest_jacobians
from craftmesh.surface.measure import area_vectors

_NAMES = ("NAME", "NSET", "ELSET", "MATERIAL", "ORIENTATION")  # parameters whose values are names


def check_deck(path: str | os.PathLike) -> list[str]:
    """Return one sentence for each fault that keeps Abaqus or CalculiX from reading a deck; [] without any.

    Included files are read in place. Checked are ASCII, line lengths, names and rows of sets, and duplicate
    ids; that elements, sets and single loads refer to existing nodes and elements; that names are defined
    and parts are in order (`reference_faults`); that user materials have the declared number of values;
    that cohesive elements are of a type that Abaqus has and are oriented correctly; and that Jacobians of
    C3D10 at the integration points, and volumes of C3D4, are positive and not too small for CalculiX.
    Raises CraftmeshError if the file is missing, or if rows of nodes or elements are incomplete.
    """
    try:
        return _breaches(read_deck_text(path))
    except CraftmeshError as error:
        raise CraftmeshError(f"{path}: {error}") from None


def _breaches(deck: DeckText) -> list[str]:
    breaches = list(deck.breaches)
    if not deck.text.isascii():
        breaches.append("the deck contains bytes that are not ASCII; expected 7-bit text")
    long = [number for number, row in enumerate(deck.text.splitlines(), 1) if len(row) > LINE_LIMIT]
    if long:
        breaches.append(f"{deck.place(long[0])}: over {LINE_LIMIT} characters ({len(long)} such lines)")
    blocks = read_blocks(deck)
    nodes, elements = (np.sort(_ids(blocks, keyword)) for keyword in ("NODE", "ELEMENT"))
    for name, ids in (("node", nodes), ("element", elements)):
        twice = int((ids[1:] == ids[:-1]).sum())
        if len(ids) and ids[-1] > NUMBER_LIMIT:
            breaches.append(
                f"the {name} id {ids[-1]} is over {NUMBER_LIMIT}, the largest that Abaqus takes"
            )
        if not len(ids):
            breaches.append(f"the deck has no {name}s; expected at least one")
        elif twice:
            breaches.append(f"{twice} {name} ids are duplicate; expected each id once")
    for block in blocks:
        breaches += [f"{block.place}: {breach}" for breach in _check_block(block, nodes, elements)]
    return breaches + reference_faults(blocks) + _check_shapes(blocks)


def _check_block(block: Block, nodes: np.ndarray, elements: np.ndarray) -> list[str]:
    names = [block.parameters[key].strip('"') for key in _NAMES if key in block.parameters]
    if block.keyword.endswith(OUTPUT):
        names = [name.rpartition(".")[2] for name in names]
    breaches = [f"the name {name[:40]!r} {fault}" for name in names if (fault := name_fault(name))]
    if block.keyword == "ELEMENT":
        table = _table(block)
        kind = block.parameters.get("TYPE", "")
        if kind.startswith("COH3D") and kind.rstrip("PT") not in ("COH3D6", "COH3D8"):
            breaches.append(f"Abaqus has no {kind}; expected COH3D6, four on each face of C3D10")
        breaches += (
            _unknown("node", table[:, 1:], nodes) if table.size else ["an element block without elements"]
        )
    elif block.keyword in ("BOUNDARY", "CLOAD"):
        single = re.findall(r"^\s*(?:[\w-]*\.)?(\d+)\s*,", block.data, re.M)
        breaches += _unknown("node", np.array(single, np.int64), nodes)
    elif block.keyword == "USER MATERIAL":
        told, count = block.parameters.get("CONSTANTS", ""), len(re.findall(r"[^,\s]+", block.data))
        if told != str(count):
            breaches.append(f"the user material has CONSTANTS={told} but {count} values; make them equal")
    elif block.keyword in ("NSET", "ELSET"):
        if any(row.rstrip(", ").count(",") >= ROW_LIMIT for row in block.data.splitlines()):
            breaches.append(f"a row of the set has over {ROW_LIMIT} entries")
        members = re.findall(r"[^,\s]+", block.data)
        ids = np.array([int(word) for word in members if word.isdecimal()], np.int64)
        if "GENERATE" not in block.parameters:
            known = nodes if block.keyword == "NSET" else elements
            breaches += _unknown("node" if known is nodes else "element", ids, known)
    return breaches


def _check_shapes(blocks: list[Block]) -> list[str]:
    """Return one sentence per block of tetrahedra with a Jacobian or a volume that is not positive.

    Then come sentences on cohesive elements of wrong node order, and one on Jacobians that are too small
    for CalculiX.
    """
    tables = [_table(block) for block in blocks if block.keyword == "NODE"]
    nodes = np.concatenate([np.zeros((0, 4)), *(table for table in tables if table.shape[1] == 4)])
    nodes = nodes[np.argsort(nodes[:, 0], kind="stable")]
    points = np.ascontiguousarray(nodes[:, 1:])
    breaches, sizes, layers = [], [np.zeros(0)], [np.zeros((0, 6), np.int64)]
    solids: list[np.ndarray] = []
    for block in blocks:
        kind = block.parameters.get("TYPE", "")
        columns = {"C3D4": 5, "C3D10": 11, "COH3D6": 7}.get(kind)
        if block.keyword != "ELEMENT" or columns is None:
            continue
        table = _table(block).astype(np.int64)
        if table.shape[1] != columns:
            breaches.append(f"{block.place}: rows of {table.shape[1]} numbers; expected {columns}")
        elif not _unknown("node", table[:, 1:], nodes[:, 0]):
            rows = np.searchsorted(nodes[:, 0], table[:, 1:])
            (layers if kind == "COH3D6" else solids).append(rows)
            if kind != "COH3D6":
                sizes.append(smallest_jacobians(points, rows))
                breaches += _check_sizes(block, table[:, 0], sizes[-1])
    breaches += _order_faults(points, np.concatenate(layers), solids)
    too_small = too_small_sentence(np.concatenate(sizes))
    return breaches + [too_small] * bool(too_small)


def _check_sizes(block: Block, ids: np.ndarray, sizes: np.ndarray) -> list[str]:
    is_linear = block.parameters["TYPE"] == "C3D4"
    what = "a volume <= 0" if is_linear else "a Jacobian <= 0 at an integration point"
    bad = np.flatnonzero(~(sizes > 0))
    grain = block.parameters.get("ELSET", "no element set")
    first = f"the first is element {ids[bad[0]]} of {grain}" if len(bad) else ""
    return [f"{block.place}: {len(bad)} elements have {what} ({first})"] if len(bad) else []


def _order_faults(points: np.ndarray, layers: np.ndarray, tets: Sequence[np.ndarray]) -> list[str]:
    """Return sentences on cohesive elements (k, 6) of wrong node order, and on duplicate ones.

    Nodes 4 to 6 must be opposite nodes 1 to 3, and the normal of nodes 1 to 3 must point out of the solid
    element that has these nodes. points (n, 3); layers: the cohesive elements as rows of points; tets:
    tables (m, 4) or (m, 10) of solid elements.
    """
    bottom, top = (area_vectors(points, layers[:, part]) for part in (slice(3), slice(3, 6)))
    faults = []
    crossed = np.flatnonzero(np.einsum("ij,ij->i", bottom, top) <= 0)
    if len(crossed):
        faults.append(f"{len(crossed)} cohesive elements have nodes 4 to 6 not over 1 to 3")
    inward = np.zeros(len(layers), bool)
    of = _incidence(layers[:, :3], len(points))
    for rows in tets:
        shared = (of @ _incidence(rows, len(points)).T).tocoo()
        layer, element = shared.row[shared.data == 3], shared.col[shared.data == 3]
        off = points[rows[element, :4]].mean(axis=1) - points[layers[layer, 0]]
        inward[layer] |= np.einsum("ij,ij->i", bottom[layer], off) > 0
    if inward.any():
        faults.append(
            f"{np.count_nonzero(inward)} cohesive elements have a normal of nodes 1 to 3 into the solid "
            "element there; expected it to point out, from nodes 1 to 3 towards 4 to 6"
        )
    if len(np.unique(np.sort(layers, axis=1), axis=0)) < len(layers):
        faults.append("several cohesive elements have the same nodes; expected each element once")
    return faults


def _incidence(rows: np.ndarray, count: int) -> "scipy.sparse.csr_array":
    """Return a sparse matrix (k, count), 1 where element k of `rows` (k, c) has the node."""
    at = np.repeat(np.arange(len(rows)), rows.shape[1])
    return scipy.sparse.csr_array(
        (np.ones(rows.size, np.int8), (at, rows.ravel())), shape=(len(rows), count)
    )


def _ids(blocks: list[Block], keyword: str) -> np.ndarray:
    tables = [_table(block)[:, 0].astype(np.int64) for block in blocks if block.keyword == keyword]
    return np.concatenate([np.zeros(0, np.int64), *tables])


def _table(block: Block) -> np.ndarray:
    """Return the numbers of a block of nodes or elements as rows (k, c), shape (0, 1) without numbers.

    Raises CraftmeshError if the numbers do not fill rows of the first row's length.
    """
    joined = re.sub(r",\s*\n", ",", block.data).strip()
    if not joined:
        return np.zeros((0, 1))
    width = joined.partition("\n")[0].rstrip(", ").count(",") + 1
    numbers = np.fromstring(joined.replace("\n", ","), sep=",")
    if len(numbers) % width:
        raise CraftmeshError(
            f"{block.place}: {len(numbers)} numbers do not fill rows of {width}, the length of the first; "
            "the deck is cut short or was changed: write it again"
        )
    return numbers.reshape(-1, width)


def _unknown(kind: str, ids: np.ndarray, known: np.ndarray) -> list[str]:
    """Return a list of one sentence if some of `ids` are not in the sorted `known`, else []."""
    ids = ids.ravel()
    place = np.searchsorted(known, ids)
    lost = np.sort(ids[np.append(known, -1)[place] != ids]).astype(np.int64)
    return [f"{kind} {lost[0]} is not in the deck ({len(lost)} such ids)"] if len(lost) else []

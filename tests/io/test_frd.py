"""Displacements from CalculiX' results, and tables of them."""

import numpy as np
import pytest

from craftmesh.errors import CraftmeshError
from craftmesh.io import model_tables
from craftmesh.io.model_tables import read_displacement_table, read_displacements


def block(name: str, rows: dict, steps=4) -> str:
    """A result block in the long ASCII form, as CalculiX prints it."""
    lines = [f"  100CL  101 1.000000000 {len(rows):11d}                     0    1           1"]
    lines += [f" -4  {name:<8}    {steps}    1", " -5  D1          1    2    1    0"]
    for node, values in rows.items():
        lines.append(f" -1{node:10d}" + "".join(f"{value:12.5E}" for value in values))
    return "\n".join([*lines, " -3", ""])


HEAD = "    1C\n    2C                             3                                     1\n"
HEAD += " -1         1 0.00000E+00 0.00000E+00 0.00000E+00\n -3\n"
EXTREME = {7: (1.0, -2.5e-7, 3e10), 12: (-9.87654e-99, 0.0, -1.0), 1234567890: (4.0, 5.0, 6.0)}


def test_displacements_are_read_from_the_last_step(tmp_path):
    first, last = {7: (0, 0, 1), 12: (0, 0, 0)}, EXTREME
    text = HEAD + block("DISP", first) + block("STRESS", {7: range(6)}) + block("DISP", last)
    (tmp_path / "a.frd").write_text(text + block("FORC", first) + " 9999\n")
    numbers, values = read_displacements(tmp_path / "a.frd")
    assert numbers.tolist() == list(last)
    assert np.allclose(values, list(last.values()), rtol=1e-5, atol=0)


@pytest.mark.parametrize("rows", [1, 2, 3, 7])
def test_blocks_of_any_length_are_read_in_pieces(tmp_path, monkeypatch, rows):
    monkeypatch.setattr(model_tables, "_ROWS", rows)
    given = {node: (node / 8, -node, 0.5) for node in range(1, 8)}
    (tmp_path / "a.frd").write_text(HEAD + block("DISP", given) + block("FORC", {1: (9, 9, 9)}) + " 9999\n")
    numbers, values = read_displacements(tmp_path / "a.frd")
    assert numbers.tolist() == list(given) and (values == list(given.values())).all()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (HEAD + block("FORC", EXTREME), "has no block DISP"),
        (HEAD + block("DISP", EXTREME)[:-40], "is truncated"),
        (
            HEAD + block("DISP", EXTREME).replace("4.00000E+00", "4.0000abc00"),
            "not in the long ASCII form",
        ),
    ],
)
def test_files_that_hold_none_are_refused(tmp_path, text, said):
    (tmp_path / "a.frd").write_text(text)
    with pytest.raises(CraftmeshError, match=said):
        read_displacements(tmp_path / "a.frd")
    with pytest.raises(CraftmeshError, match="no such file"):
        read_displacements(tmp_path / "b.frd")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "empty; .*node, ux"),
        ("node,ux,uy\n1,2,3\n", "no column 'uz'"),
        ("node,ux,uy,uz\n1,2,3\n", "columns"),
        ("node,ux,uy,uz\n1,2,3,a\n", "expected csv"),
        ("node,ux,uy,uz\n1.5,2,3,4\n", "fractions"),
    ],
)
def test_tables_in_another_form_are_refused(tmp_path, text, said):
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(CraftmeshError, match=said):
        read_displacement_table(tmp_path / "a.csv")


def test_tables_are_read_from_csv_and_npz(tmp_path):
    (tmp_path / "a.csv").write_text("Node, UX, UY, UZ\n3,1,2,3\n1,0,-1e-3,5\n")
    numbers, values = read_displacement_table(tmp_path / "a.csv")
    assert numbers.tolist() == [3, 1] and values.tolist() == [[1, 2, 3], [0, -1e-3, 5]]
    np.savez(tmp_path / "a.npz", node=numbers, displacement=values)
    again = read_displacement_table(tmp_path / "a.npz")
    assert (again[0] == numbers).all() and (again[1] == values).all()
    np.savez(tmp_path / "b.npz", node=numbers[:1], displacement=values)
    with pytest.raises(CraftmeshError, match="its entries are node, displacement"):
        read_displacement_table(tmp_path / "b.npz")

"""Every kind of table in text, in every dialect that programs write, is read as the plain one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from craftmesh.errors import CraftmeshError
from craftmesh.io.front_csv import front_table, read_fronts
from craftmesh.io.model_tables import read_displacement_table as read_displacements
from craftmesh.io.point_files import read_points, read_source_points
from craftmesh.io.text_table import read_table

POINTS = np.array([[1.5, -2.25, 3.0], [4.0, 5.5e-3, 6.0], [-7.0, 8.125, 9.0]])
RADII = np.array([[0.5], [1.25], [2.0]])
NODES = np.array([[3.0], [1.0], [2.0]])
KINDS = {
    "front": (("x", "y", "z"), POINTS, "f.csv", lambda path: front_table(path).numbers("xyz")),
    "fronts": (("front", "x", "y", "z"), np.hstack([NODES * 0 + 1, POINTS]), "f.csv", read_fronts),
    "path": (("x", "y"), POINTS[:, :2], "p.csv", lambda path: front_table(path, "xy").numbers("xy")),
    "cloud": (("x", "y", "z"), POINTS, "c.csv", read_points),
    "cloud as text": (("x", "y", "z"), POINTS, "c.txt", read_points),
    "points": (("x", "y", "z"), POINTS, "s.csv", lambda p: read_source_points(p).points),
    "voids": (
        ("x", "y", "z", "r"),
        np.hstack([POINTS, RADII]),
        "v.csv",
        lambda p: read_source_points(p).voids,
    ),
    "pores": (
        ("eqdiameter", "barycenterx", "barycentery", "barycenterz"),
        np.hstack([RADII, POINTS]),
        "a.csv",
        lambda p: read_source_points(p).spheres,
    ),
    "displacements": (("node", "ux", "uy", "uz"), np.hstack([NODES, POINTS]), "d.csv", read_displacements),
}


def written(names, rows, between=",", mark=".", above="", end="\n", unit="", quote="") -> str:
    """Return a table as text."""
    cells = [[f"{quote}{name}{unit}{quote}" for name in names]]
    cells += [[f"{quote}{number!r}{quote}".replace(".", mark) for number in row] for row in rows.tolist()]
    return above + end.join(between.join(row) for row in cells) + end


DIALECTS = {
    "tabs": {"between": "\t"},
    "semicolons": {"between": ";"},
    "blanks": {"between": "   "},
    "commas and blanks": {"between": ", "},
    "semicolons, decimal commas": {"between": ";", "mark": ","},
    "tabs, decimal commas": {"between": "\t", "mark": ","},
    "blanks, decimal commas": {"between": " ", "mark": ","},
    "quotes": {"quote": '"'},
    "quotes, decimal commas": {"quote": '"', "mark": ","},
    "units": {"unit": " [um]"},
    "units in blanks": {"unit": " (mm)", "between": "  "},
    "comment": {"above": "# exported by x, 1.5\n// and y\n\n"},
    "title": {"above": "Sheet 1;;\n"},
    "CRLF": {"end": "\r\n"},
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_all_kinds_in_all_dialects(tmp_path, kind, encoding):
    names, rows, file, read = KINDS[kind]
    path = tmp_path / file

    def values(text: str) -> np.ndarray:
        path.write_bytes(text.encode(encoding))
        found = read(path)
        return np.column_stack(found) if isinstance(found, tuple) else np.asarray(found)

    plain = values(written(names, rows))
    assert plain.size >= rows.size - len(rows)
    for dialect, how in DIALECTS.items():
        for heads in (names, [name.upper() for name in names]):
            assert np.array_equal(values(written(heads, rows, **how)), plain), (dialect, heads)


WRONG = [
    (
        "x,y,z\n1,5,2,5,3,5\n",
        "line 2: has 6 cells; expected 3; save numbers with points, or with semicolons",
    ),
    ("x;y;z\n1,5;2;3\n4;5.5;6\n", "line 3: has a decimal point, but column x has decimal commas"),
    ("x;y;z\n1.234,5;2;3\n", "line 2: x is '1.234,5'; expected a finite number"),
    ("x;y;z\n1,234,5;2;3\n", "line 2: x is '1,234,5'; expected a finite number"),
    ("x [um],y [mm],z [um]\n1,2,3\n", "columns x .um., y .mm., z .um. differ in unit; use one unit"),
    ("x,y,z,X\n1,2,3,4\n", "duplicate column name 'x'"),
    ("x [um],y [um],z [um],x [px]\n1,2,3,4\n", "duplicate column name 'x'"),
    ("# c\n\nx,y,z\n1,2,3\n\n4,5\n", "line 6: has 2 cells; expected 3"),
    ("x,y,z\n1,2,3\n4,5,6,7\n", "line 3: has 4 cells; expected 3"),
    ("x,y,z\n1,2,3\n4,5,six\n", "line 3: z is 'six'; expected a finite number"),
    ("x,y,z\n1,2,3\n4,,6\n", "line 3: y is ''; expected a finite number"),
    ("x,y,z\n1,2,inf\n", "line 2: z is 'inf'; expected a finite number"),
    ("x,y\n1,2\n", "no column 'z' .found: x, y.; the header must name x, y, z"),
    ('x,y,z\n"1,2,3\n4,5,6\n', "a quotation mark is not closed"),
    ("# nothing\n", "is empty; give a table with the columns x, y, z"),
    ("\0\0\0\0", "is not a text file"),
]


@pytest.mark.parametrize(("text", "said"), WRONG)
@pytest.mark.parametrize("kind", ["front", "cloud", "cloud as text", "points"])
def test_what_is_no_table_is_one_line_with_file_and_line(tmp_path, kind, text, said):
    _, _, file, read = KINDS[kind]
    (tmp_path / file).write_text(text)
    with pytest.raises(CraftmeshError, match=said) as caught:
        read(tmp_path / file)
    assert file in str(caught.value) and "\n" not in str(caught.value)


def test_a_header_in_a_comment_names_the_columns(tmp_path):
    np.savetxt(tmp_path / "f.csv", POINTS[:, ::-1], header="z [um] y [um] x [um]")
    assert np.array_equal(front_table(tmp_path / "f.csv").numbers("xyz"), POINTS)


@pytest.mark.parametrize("between", [",", ", ", ";", "\t", " ", " \t "])
def test_bare_numbers_need_no_header(tmp_path, between):
    (tmp_path / "f.csv").write_text("\n".join(between.join(map(repr, row)) for row in POINTS.tolist()))
    assert np.array_equal(front_table(tmp_path / "f.csv").numbers("xyz"), POINTS)


NUMBERS = st.floats(-1e12, 1e12, allow_subnormal=False).map(lambda x: x + 0.0)
NAMES = st.lists(st.from_regex(r"[a-wA-W][a-zA-Z0-9_]{0,6}", fullmatch=True), max_size=3)


@settings(max_examples=40)
@given(
    st.lists(st.tuples(NUMBERS, NUMBERS, NUMBERS), min_size=1, max_size=6),
    NAMES.filter(lambda names: len({name.casefold() for name in names}) == len(names)),
    st.sampled_from(
        [(",", "."), (";", "."), (";", ","), ("\t", "."), ("\t", ","), (" ", "."), ("  ", ",")]
    ),
    st.sampled_from(["", " [um]", " (\u00b5m)", "[mm]"]),
    st.sampled_from(["utf-8", "utf-8-sig", "utf-16"]),
    st.sampled_from(["\n", "\r\n"]),
    st.permutations(range(3)),
)
def test_a_table_goes_through_any_dialect_bit_for_bit(
    tmp_path_factory, rows, others, marks, unit, encoding, end, order
):
    path = tmp_path_factory.getbasetemp() / "any.csv"
    values = np.array(rows)
    names = [*("xYz"[axis] for axis in order), *others]
    cells = np.hstack([values[:, list(order)], np.zeros((len(values), len(others)))])
    path.write_bytes(written(names, cells, *marks, end=end, unit=unit).encode(encoding))
    assert np.array_equal(read_table(path, "xyz").numbers("xyz"), values)

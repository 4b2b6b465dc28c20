"""Crack fronts as text: any header that names x, y, z, and craftmesher's headerless files."""

import numpy as np
import pytest

from craftmesh.errors import CraftmeshError
from craftmesh.io.front_csv import front_table, read_front, write_front


def test_columns_come_back_bit_for_bit(tmp_path):
    random = np.random.default_rng(1)
    columns = {"front": np.array([1, 1, 2]), "s": random.random(3)}
    columns |= {name: random.normal(size=(3, 3)) for name in ("points", "tangent")}
    write_front(tmp_path / "front.csv", columns)
    read = read_front(tmp_path / "front.csv")
    assert list(read) == ["front", "s", "x", "y", "z", "tangent_x", "tangent_y", "tangent_z"]
    assert (read["s"] == columns["s"]).all()
    assert (front_table(tmp_path / "front.csv").numbers("xyz") == columns["points"]).all()
    assert (np.stack([read[f"tangent_{a}"] for a in "xyz"], 1) == columns["tangent"]).all()
    assert (tmp_path / "front.csv").read_text().splitlines()[1].startswith("1,0.")


def test_columns_are_found_by_name_whatever_their_order(tmp_path):
    (tmp_path / "f.csv").write_text(" z , remark,x,y\n3,deep,1,2\n\n6,mouth,4,5\n")
    assert front_table(tmp_path / "f.csv").numbers("xyz").tolist() == [[1, 2, 3], [4, 5, 6]]
    assert "remark" not in read_front(tmp_path / "f.csv")


def test_headerless_files(tmp_path):
    (tmp_path / "f.csv").write_text("0,0,0,0,0,0,0,1.5,2.5,3.5\n0,0,0,0,0,0,0,4,5,6\n")
    assert front_table(tmp_path / "f.csv").numbers("xyz").tolist() == [[1.5, 2.5, 3.5], [4, 5, 6]]
    (tmp_path / "f.csv").write_text("1,2,3\n4,5,6\n")
    assert front_table(tmp_path / "f.csv").numbers("xyz").tolist() == [[1, 2, 3], [4, 5, 6]]


def test_craftmesher_example(shared_data):
    points = front_table(shared_data / "defects/craftmesher_AdvCrack.csv").numbers("xyz")
    assert points.shape[1] == 3 and points[0].tolist() == [
        23.85648985261602,
        2.3164245662542067,
        48.764410560331676,
    ]


@pytest.mark.parametrize(
    "text, said",
    [
        ("", "empty"),
        ("x,y\n1,2\n", "no column 'z'"),
        ("x,y,z\n", "no row below the header; add at least one"),
        ("x,y,z\n1,2,3\n1,2,nan\n", "line 3: z is 'nan'; expected a finite number"),
        ("x,y,z\n1,2,up\n", "line 2: z is 'up'; expected a finite number"),
        ("x,y,z\n1,2,3\n1,2\n", "line 3: has 2 cells; expected 3"),
        ("1,2,3,4\n", "no header"),
    ],
)
def test_what_cannot_be_a_front_is_said_in_one_line(text, said, tmp_path):
    (tmp_path / "f.csv").write_text(text)
    with pytest.raises(CraftmeshError, match=said) as error:
        read_front(tmp_path / "f.csv")
    assert "f.csv" in str(error.value) and "\n" not in str(error.value)

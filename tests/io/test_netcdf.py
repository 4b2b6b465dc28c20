"""NetCDF files hold what was given, the same input as the same bytes; what does not fit is refused."""

import numpy as np
import pytest

from craftmesh.errors import CraftmeshError
from craftmesh.io.mesh_formats import LARGEST, Variable, write_netcdf

DIMENSIONS = {"time": None, "rows": 3, "letters": 2}
VARIABLES = [
    Variable("count", ("rows",), np.array([1, -2, 2**31 - 1], np.int32), {"name": "ID"}),
    Variable("place", ("rows",), np.array([1 / 3, -0.0, 1e300])),
    Variable("text", ("rows", "letters"), np.array([b"ab", b"c", b""], "S2").view("S1").reshape(3, 2)),
    Variable("value", ("time", "rows"), np.array([[1.5, 2.5, 3.5]])),
]
ATTRIBUTES = {"title": "craftmesh", "version": np.float32(5.1), "file_size": np.int32(1)}


def test_variables_and_attributes_come_back(tmp_path):
    netCDF4 = pytest.importorskip("netCDF4")
    write_netcdf(tmp_path / "a.nc", DIMENSIONS, VARIABLES, ATTRIBUTES)
    with netCDF4.Dataset(tmp_path / "a.nc") as file:
        assert file.data_model == "NETCDF3_64BIT_OFFSET"
        assert {name: file.getncattr(name) for name in file.ncattrs()} == ATTRIBUTES
        assert list(file.variables) == [variable.name for variable in VARIABLES]  # meshio reads by order
        for variable in VARIABLES:
            found = file[variable.name]
            found.set_auto_maskandscale(False)
            assert found.dimensions == variable.dimensions
            assert np.array_equal(found[:], variable.values)
        assert file["count"].getncattr("name") == "ID"


def test_the_same_input_gives_the_same_bytes(tmp_path):
    for name in ("a.nc", "b.nc"):
        write_netcdf(tmp_path / name, DIMENSIONS, VARIABLES, ATTRIBUTES)
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


def test_a_variable_over_two_gib_is_refused_before_anything_is_written(tmp_path):
    rows = LARGEST // 4 + 1
    large = Variable("connect1", ("rows",), np.broadcast_to(np.int32(0), rows))  # takes no memory
    with pytest.raises(CraftmeshError, match=rf"a\.nc: connect1 needs {4 * rows} bytes"):
        write_netcdf(tmp_path / "a.nc", {"rows": rows}, [large], {})
    assert not list(tmp_path.iterdir())

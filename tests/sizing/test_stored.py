"""A sizing function survives its file bit for bit; what is no sizing is refused by name."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from craftmesh.errors import CraftmeshError
from craftmesh.io.npz import write_arrays
from craftmesh.io.stage_npz import is_sizing, read_sizing, write_sizing
from craftmesh.sizing.length_field import LengthField
from craftmesh.sizing.sizing import Sizing
from craftmesh.sizing.stored import arrays_of, sizing_of

PLACES = np.random.default_rng(5).uniform(-2, 12, (400, 3))


def random_sizing(seed: int, sources: int, fields: int, growth: float | None) -> Sizing:
    rng = np.random.default_rng(seed)
    l_min, l0, l_max = np.sort(rng.uniform(0.1, 3, 3))
    r0, r1 = np.sort(rng.uniform(0, 9, 2))
    others = [
        LengthField(rng.uniform(0, 10, (k, 3)), rng.uniform(0.2, 2, k)) for k in rng.integers(1, 40, fields)
    ]
    if growth is not None:
        others = [other.limited(growth) for other in others]
    around = rng.uniform(0, 10, (sources, 3))
    return Sizing(l_min, l0, l_max, r0, r1, rng.uniform(0.3, 3), around, growth, tuple(others))


@settings(max_examples=25)
@given(st.integers(0, 10**6), st.integers(0, 30), st.integers(0, 3), st.sampled_from([None, 0.2, 1.0]))
def test_a_sizing_comes_back_bit_for_bit(tmp_path_factory, seed, sources, fields, growth):
    folder = tmp_path_factory.mktemp("sizing")
    sizing = random_sizing(seed, sources, fields, growth)
    for name in ("a.npz", "b.npz"):
        write_sizing(folder / name, arrays_of(sizing))
    again = sizing_of(read_sizing(folder / "a.npz"))
    assert again.at(PLACES).tobytes() == sizing.at(PLACES).tobytes()
    assert again.growth == sizing.growth and np.array_equal(again.sources, sizing.sources)
    assert (folder / "a.npz").read_bytes() == (folder / "b.npz").read_bytes()


def test_a_sizing_within_a_sizing_is_refused():
    inner = random_sizing(1, 2, 0, None)
    outer = Sizing(0.5, 1.0, 3.0, 8.0, 16.0, 1.0, np.zeros((1, 3)), others=(inner,))
    with pytest.raises(CraftmeshError, match="use only LengthFields"):
        arrays_of(outer)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"format": np.array("craftmesh labels 1")}, "is not a sizing; expected a sizing.npz"),
        ({"l_min": None}, "no entry l_min"),
        ({"l0": np.ones(2)}, r"l0 has shape \(2,\)"),
        ({"sources": np.zeros((4, 2))}, r"sources has shape \(4, 2\)"),
        ({"field_counts": np.array([7])}, r"field_counts \[7\] do not fit"),
        ({"field_growth": np.zeros(2)}, "field_counts .* do not fit .* 2 field_growth"),
    ],
)
def test_entries_that_are_not_so_are_named(tmp_path, change, said):
    path = tmp_path / "sizing.npz"
    write_sizing(path, arrays_of(random_sizing(3, 4, 1, None)))
    with np.load(path) as archive:
        arrays = dict(archive) | change
    write_arrays(path, {name: values for name, values in arrays.items() if values is not None})
    with pytest.raises(CraftmeshError, match=said) as caught:
        read_sizing(path)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)


def test_a_file_that_is_missing_or_torn_is_named(tmp_path):
    with pytest.raises(CraftmeshError, match="gone.npz: no such file"):
        read_sizing(tmp_path / "gone.npz")
    write_sizing(tmp_path / "whole.npz", arrays_of(random_sizing(3, 400, 1, None)))
    assert is_sizing(tmp_path / "whole.npz")
    (tmp_path / "torn.npz").write_bytes((tmp_path / "whole.npz").read_bytes()[:500])
    with pytest.raises(CraftmeshError, match="torn.npz"):
        read_sizing(tmp_path / "torn.npz")

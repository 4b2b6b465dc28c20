"""Elastic materials: the constants mean what their names say."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.materials import Material, mean_moduli, parse_materials, turned
from craftmesh.mechanics.near_field import as_tensor
from craftmesh.mechanics.orientation import quaternion_to_matrix, random_orientations


def test_isotropic_stiffness_inverts_to_hooke():
    compliance = np.linalg.inv(Material("isotropic", (200e3, 0.3)).stiffness())
    assert compliance[0, :3] == pytest.approx([1 / 200e3, -0.3 / 200e3, -0.3 / 200e3])
    assert compliance[3, 3] == pytest.approx(2 * 1.3 / 200e3)


def test_cubic_with_zener_ratio_one_is_isotropic():
    isotropic = Material("isotropic", (70e3, 0.33)).stiffness()
    c11, c12, c44 = isotropic[0, 0], isotropic[0, 1], isotropic[5, 5]
    assert np.allclose(Material("cubic", (c11, c12, c44)).stiffness(), isotropic, rtol=1e-14)


TITANIUM = (162.4, 92.0, 69.0, 180.7, 46.7)


def test_hexagonal_constants_are_those_of_the_tensor():
    """c66 follows from isotropy about c; sigma = C : epsilon is written out index by index."""
    c11, c12, c13, c33, c44 = TITANIUM
    strain = np.array([[1.0, 0.4, -0.3], [0.4, -0.5, 0.2], [-0.3, 0.2, 0.7]])
    stress = np.array(
        [
            [c11 * 1.0 + c12 * -0.5 + c13 * 0.7, (c11 - c12) * 0.4, 2 * c44 * -0.3],
            [(c11 - c12) * 0.4, c12 * 1.0 + c11 * -0.5 + c13 * 0.7, 2 * c44 * 0.2],
            [2 * c44 * -0.3, 2 * c44 * 0.2, c13 * 1.0 + c13 * -0.5 + c33 * 0.7],
        ]
    )
    tensor = as_tensor(Material("hexagonal", TITANIUM).stiffness()[None])[0]
    assert np.allclose(np.einsum("ijkl,kl->ij", tensor, strain), stress, rtol=1e-14)


@settings(max_examples=30)
@given(st.floats(0, 2 * np.pi), st.integers(0, 2**32 - 1))
def test_hexagonal_crystals_turn_as_tensors_and_about_c_not_at_all(angle, seed):
    stiffness = Material("hexagonal", TITANIUM).stiffness()
    turn = quaternion_to_matrix(random_orientations(1, np.random.default_rng(seed)))[0]
    plain = np.einsum("ai,bj,ck,dl,ijkl->abcd", turn, turn, turn, turn, as_tensor(stiffness[None])[0])
    assert np.allclose(as_tensor(turned(stiffness, turn)[None])[0], plain, atol=1e-12 * 180)
    cos, sin = np.cos(angle), np.sin(angle)
    about_c = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
    assert np.allclose(turned(stiffness, about_c), stiffness, atol=1e-12 * 180)


def test_hexagonal_with_an_isotropic_solids_constants_is_isotropic():
    isotropic = Material("isotropic", (70e3, 0.33)).stiffness()
    c11, c12, c44 = isotropic[0, 0], isotropic[0, 1], isotropic[5, 5]
    hexagonal = Material("hexagonal", (c11, c12, c12, c11, c44))
    assert np.allclose(hexagonal.stiffness(), isotropic, rtol=1e-14)


def test_anisotropic_constants_go_where_their_indices_say():
    names = "1111 1122 2222 1133 2233 3333 1112 2212 3312 1212 1113 2213 3313 1213 1313 "
    names += "1123 2223 3323 1223 1323 2323"
    pairs = ["11", "22", "33", "12", "13", "23"]
    stiff = [10.0 if name[:2] == name[2:] else 0.01 * k for k, name in enumerate(names.split())]
    material = Material("anisotropic", stiff)
    for value, name in zip(stiff, names.split()):
        row, column = pairs.index(name[:2]), pairs.index(name[2:])
        assert material.stiffness()[row, column] == material.stiffness()[column, row] == value
    assert material.upper_triangle() == stiff


@pytest.mark.parametrize(
    "kind, constants, said",
    [
        ("elastic", (1, 2), "unknown"),
        ("cubic", (1, 2), "expected 3"),
        ("cubic", (61.3e3, 108.2e3, 28.5e3), "strain energy"),
        ("hexagonal", (162.4, 92.0, 69.0), "expected 5"),
        ("hexagonal", (162.4, 92.0, 69.0, 30.0, 46.7), "strain energy"),  # c33 (c11 + c12) < 2 c13^2
        ("hexagonal", (92.0, 162.4, 69.0, 180.7, 46.7), "strain energy"),
        ("isotropic", (70e3, 0.5), "strain energy"),
        ("isotropic", (70e3, 0.7), "strain energy"),
        ("isotropic", (float("nan"), 0.3), "strain energy"),
    ],
)
def test_impossible_materials_are_refused(kind, constants, said):
    with pytest.raises(CraftmeshError, match=said):
        Material(kind, constants)


def test_materials_are_read_by_phase():
    assert parse_materials(["isotropic:70e3,0.33"]) == {None: Material("isotropic", (70e3, 0.33))}
    two = parse_materials(["1=cubic:108.2e3, 61.3e3, 28.5e3", "2=isotropic:200e3,.3"])
    assert two == {1: Material("cubic", (108.2e3, 61.3e3, 28.5e3)), 2: Material("isotropic", (200e3, 0.3))}


@pytest.mark.parametrize(
    "texts", [[], ["cubic"], ["x=cubic:1,2,3"], ["cubic:1;2;3"], ["isotropic:1,0", "1=isotropic:1,0"]]
)
def test_other_texts_are_refused(texts):
    with pytest.raises(CraftmeshError, match="^material"):
        parse_materials(texts)


def test_a_phase_given_twice_is_refused():
    with pytest.raises(CraftmeshError, match="second entry for its phase"):
        parse_materials(["1=isotropic:1,0", "1=isotropic:2,0"])


def test_mean_moduli_of_cubic_and_hexagonal_crystals_are_the_printed_ones_whatever_their_axes():
    """Hill, Proc. Phys. Soc. A 65 (1952); Ranganathan & Ostoja-Starzewski, PRL 101 (2008)."""
    c11, c12, c44 = 168.4, 121.4, 75.4
    h11, h12, h13, h33, h44 = TITANIUM
    turn = quaternion_to_matrix(random_orientations(1, np.random.default_rng(6)))[0]
    crystals = [Material("cubic", (c11, c12, c44)), Material("hexagonal", TITANIUM)]
    found = mean_moduli(np.stack([turned(crystal.stiffness(), turn) for crystal in crystals]))
    bulk, zener = (c11 + 2 * c12) / 3, 2 * c44 / (c11 - c12)
    assert found.voigt_bulk == pytest.approx([bulk, (2 * (h11 + h12) + 4 * h13 + h33) / 9])
    squeezed = ((h11 + h12) * h33 - 2 * h13**2) / (h11 + h12 + 2 * h33 - 4 * h13)
    assert found.reuss_bulk == pytest.approx([bulk, squeezed])
    h66 = (h11 - h12) / 2
    even = (h11 + h12 + 2 * h33 - 4 * h13 + 12 * h44 + 12 * h66) / 30
    assert found.voigt_shear == pytest.approx([(c11 - c12 + 3 * c44) / 5, even])
    assert found.reuss_shear[0] == pytest.approx(5 * (c11 - c12) * c44 / (4 * c44 + 3 * (c11 - c12)))
    assert (found.reuss_shear < found.voigt_shear).all()
    known = 5 * found.voigt_shear / found.reuss_shear + found.voigt_bulk / found.reuss_bulk - 6
    assert found.anisotropy == pytest.approx([6 / 5 * (zener**0.5 - zener**-0.5) ** 2, known[1]])


def test_mean_moduli_of_an_isotropic_material_are_its_own():
    found = mean_moduli(Material("isotropic", (200e3, 0.3)).stiffness()[None])
    assert found.voigt_bulk == found.reuss_bulk == pytest.approx(200e3 / (3 * (1 - 2 * 0.3)))
    assert found.voigt_shear == pytest.approx(200e3 / 2.6) and found.reuss_shear == pytest.approx(
        200e3 / 2.6
    )
    assert found.anisotropy == pytest.approx(0, abs=1e-12)

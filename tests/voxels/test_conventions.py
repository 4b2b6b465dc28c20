"""One orientation in every format: Bunge's angles (30, 40, 50), its numbers as the format has them.

The numbers are those of orix 0.15 (DREAM.3D's quaternions, by D. Rowenhorst et al., Modelling Simul. Mater.
Sci. Eng. 23 (2015) 083501) and of DAMASK 3.1 (the others), which read Bunge's angles by themselves.
"""

import numpy as np
import pytest
from side_tables import LABELS, dream3d, labdct, npz, ori, oridata, tesr, vti

from craftmesh.mechanics.orientation import quaternion_to_matrix
from craftmesh.voxels.reading import ReadOptions, read_voxels

ANGLES = np.radians([30.0, 40.0, 50.0])
QUATERNION = np.array([0.71984631, 0.33682409, -0.05939117, 0.60402277])
VECTOR = np.array([0.46791111, -0.08250535, 0.83909963])
LAST, SIGNS = QUATERNION[[1, 2, 3, 0]], np.array([-1, -1, -1, 1])  # as DREAM.3D orders them: x, y, z, w


def bunge(phi1, Phi, phi2):
    """Return g, from sample to crystal axes; H.-J. Bunge, Texture Analysis in Materials Science, 2.1."""
    c1, c, c2 = np.cos([phi1, Phi, phi2])
    s1, s, s2 = np.sin([phi1, Phi, phi2])
    return np.array(
        [
            [c1 * c2 - s1 * s2 * c, s1 * c2 + c1 * s2 * c, s2 * s],
            [-c1 * s2 - s1 * c2 * c, -s1 * s2 + c1 * c2 * c, c2 * s],
            [s1 * s, -c1 * s, c],
        ]
    )


def by_grain(row):
    return np.vstack([np.zeros(np.size(row)), *[row] * 3])


def by_voxel(row):
    return np.broadcast_to(row, (*LABELS.shape, np.size(row)))


def neper(section, version, descriptor, row):
    def write(folder):
        rows = by_grain(row)[1:] if section is ori else by_grain(row)
        return tesr(folder, version=version, **section(descriptor, rows))

    return write


FORMATS = {
    "npz, quaternions": lambda p: npz(p, orientations=by_grain(QUATERNION)),
    "npz, Rodrigues vectors": lambda p: npz(p, rodrigues=by_grain(VECTOR)),
    "npz, Bunge's angles": lambda p: npz(p, eulers=by_grain(ANGLES)),
    "npz, angles of voxels": lambda p: npz(p, eulers=by_voxel(ANGLES)),
    "vti, angles of voxels": lambda p: vti(p, EulerAngles=by_voxel(ANGLES)),
    "LabDCT, Rodrigues vectors": lambda p: labdct(p, Rodrigues=by_voxel(VECTOR)),
    **{
        f"DREAM.3D {v}, angles": lambda p, v=v: dream3d(p, v, [("", "AvgEulerAngles", by_grain(ANGLES))])
        for v in (4, 5, 7, 8)
    },
    **{
        f"DREAM.3D {v}, quaternions": lambda p, v=v, q=q: dream3d(p, v, [("", "AvgQuats", by_grain(q))])
        for v, q in {4: LAST, 5: LAST, 7: LAST * SIGNS, 8: LAST * SIGNS}.items()
    },
    **{
        f"tesr {v} {name} {section.__name__}": neper(section, v, f"{name}{word}", row)
        for v, word in {"2.0": "", "2.1": ":active", "2.2": ":passive"}.items()
        for name, row in {
            "rodrigues": VECTOR,
            "euler-bunge": np.array([30.0, 40.0, 50.0]),
            "quaternion": QUATERNION,
            "rotmat": bunge(*ANGLES).ravel(),
        }.items()
        for section in (ori, oridata)
    },
    "tesr 2.2, active": neper(ori, "2.2", "rodrigues:active", -VECTOR),
}


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_gives_one_matrix(tmp_path, name):
    raw = read_voxels(FORMATS[name](tmp_path), ReadOptions())
    R = quaternion_to_matrix(raw.voxels.orientations[1:])
    wanted = bunge(*ANGLES).T
    # float32 angles in .dream3d and .vti are good to 1e-7, the numbers above to 8 digits
    np.testing.assert_allclose(R, np.broadcast_to(wanted, R.shape), atol=1e-6)

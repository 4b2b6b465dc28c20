"""Noisy volumes through the whole chain: generated ones, as they are and smoothed, and measured ones."""

import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from cases import DATA, ROOT, with_crack
from measure import flags, print_table, repeated, timed, write_json

# Lengths of Eq. 3 over the voxel's edge, for generated volumes.
SIZES = {"l_min": 0.6, "l0": 1.0, "r0": 6.0, "r1": 12.0}
# Voxels: what cleaning gives away, on all generated volumes.
ISLANDS = 8
FLAT = (5.0, 172.0)  # degrees; a tet with a dihedral angle beyond is flat


@dataclass(frozen=True)
class Noisy:
    """A volume: options of the generator and l_max in voxel edges, or an example's name with its file."""

    generated: dict = field(default_factory=dict)
    l_max: float = 3.0
    example: str = ""
    file: Path | None = None


CASES = {
    "tiny": Noisy({"shape": (20, 20, 20), "grains": 6, "shuffled": 0.3}),
    "laths": Noisy(
        {
            "shape": (35, 40, 59),
            "spacing": (0.4, 0.4, 0.12),
            "grains": 160,
            "columnar_axis": "y",
            "columnar_ratio": 3.0,
            "lath_ratio": 2.0,
            "raggedness": 0.5,
            "shuffled": 0.3,
        },
        l_max=1.5,  # laths are two to five voxels wide and thick
    ),
    "shuffled": Noisy({"shape": (64, 64, 64), "grains": 60, "shuffled": 0.4, "shuffle_rounds": 2}),
    "ragged": Noisy({"shape": (64, 64, 64), "grains": 60, "raggedness": 0.7}),
    "voids": Noisy({"shape": (56, 56, 56), "grains": 30, "voids": 6, "void_radius": 4.0, "shuffled": 0.3}),
    "columns": Noisy(
        {
            "shape": (60, 60, 40),
            "spacing": (1.0, 1.0, 2.0),
            "grains": 60,
            "columnar_ratio": 3.0,
            "raggedness": 0.4,
            "shuffled": 0.2,
            "shuffle_rounds": 2,
        }
    ),
    "al1050": Noisy(example="al1050", file=DATA / "al1050" / "al1050_labdct_109x103x64.npz"),
    "al6xn": Noisy(example="al6xn", file=DATA / "al6xn" / "prisms_al6xn_68x64x46.npz"),
}
DEFAULT = tuple(name for name in CASES if name != "tiny")
COLUMNS = {
    "case": "case",
    "method": "voxels",
    "roughness": "roughness",
    "changed": "changed %",
    "tets": "tets",
    "cpu_s": "CPU s",
    "ar_mean": "mean AR",
    "ar_under_5_pct": "AR<5 %",
    "poor_pct": "poor %",
    "dihedral_min": "least dihedral",
    "dihedral_max": "largest",
    "flat": "flat tets",
    "regular_far": "far regular 5/50/95%",
    "junction_far": "far junction",
    "drift": "drift mean %",
}


def volume_of(case: Noisy) -> tuple:
    """Return the voxels (raw volume), the options of `import`, the sizes and the crack of a case."""
    from craftmesh.voxels.generate import GenerateOptions, generate
    from craftmesh.voxels.reading import read_voxels

    if case.example:
        import yaml

        config = yaml.safe_load((ROOT / "examples" / case.example / "config.yaml").read_text())
        (crack,) = config["cracks"].values()
        return read_voxels(case.file), config.get("import", {}), config["sizing"], crack
    voxels = generate(GenerateOptions(**case.generated, seed=1))
    edge = float(voxels.spacing.prod() ** (1 / 3))
    size = voxels.box[1]
    crack = {
        "shape": "penny",
        "centre": (size[0] / 2, 0.0, size[2] / 2),
        "radius": float(size.min()) / 4,
    }
    sizes = {k: v * edge for k, v in (SIZES | {"l_max": case.l_max}).items()}
    return voxels, {"min_island_voxels": ISLANDS}, sizes, crack


def run(name: str, smoothing: dict) -> dict:
    """Take a case from its voxels to tetrahedra; return cost and figures."""
    from craftmesh.voxels.clean import CleanOptions, clean

    volume, importing, sizes, crack = volume_of(CASES[name])
    raw, _ = clean(volume, CleanOptions(**importing))
    voxels, report = clean(volume, CleanOptions(**importing, **smoothing))
    (surface, sizing, mesh), cost = timed(meshed, voxels, sizes, crack)
    changed = 100 * float(np.mean(voxels.labels != raw.labels))
    return (
        cost
        | {"roughness": report["roughness"], "changed": changed}
        | figures_of(surface, sizing, mesh, raw)
    )


def meshed(voxels, sizes: dict, crack: dict) -> tuple:
    """Return the gradated surface, the sizing and the opened mesh of cleaned voxels."""
    from craftmesh.assembly.assemble import assemble
    from craftmesh.gradation.gradate import gradate
    from craftmesh.remeshing.remesh import remesh, voxel_volumes
    from craftmesh.tetrahedra.volume import mesh_volume
    from craftmesh.voxels.islands import find_islands

    surface, _ = remesh(voxels)
    start = with_crack(surface, crack, voxels.box, sizes | {"exponent": 1.0}, find_islands(voxels))
    surface, _ = gradate(start.surface, start.sizing, volumes=voxel_volumes(voxels))
    opened, _ = mesh_volume(surface, start.sizing, islands=start.islands)
    return opened.surface, start.sizing, assemble(opened.surface, opened.grain_tets)[0]


def figures_of(surface, sizing, mesh, raw) -> dict:
    """Return quality, flat tets, far edges' lengths over target, and the drift from the `raw` voxels."""
    from craftmesh.gradation.report import size_adherence
    from craftmesh.mesh.quality import quality
    from craftmesh.mesh.shape_measures import shape_measures

    measures = quality(mesh, raw)
    adherence = size_adherence(surface, sizing)
    _, _, low, high, _ = shape_measures(mesh.points, np.ascontiguousarray(mesh.tets)).T
    return (
        {key: measures[key] for key in COLUMNS if key in measures}
        | {key: adherence[key] for key in ("regular_far", "junction_far")}
        | {
            "tets": len(mesh.tets),
            "flat": int(((low < FLAT[0]) | (high > FLAT[1])).sum()),
            "drift": 100 * measures["volume_drift"]["mean"],
        }
    )


def methods_of(case: Noisy) -> dict[str, dict]:
    """Return the options of cleaning that a case is run with, by name."""
    if case.example:
        return {"as measured": {}}
    return {"noisy": {}, "smoothed": {"smoothing_rounds": 2}}


def main() -> None:
    arguments = flags(__doc__, list(CASES)).parse_args()
    content: dict = {"rows": []}
    for name in arguments.case or DEFAULT:
        case = CASES[name]
        if case.file and not case.file.exists():
            print(f"{name}: skipped, {case.file.name} is not in ../shared/data")
            continue
        for method, smoothing in methods_of(case).items():
            print(f"{name}, {method} ...", file=sys.stderr)
            row = repeated(arguments.runs, run, name, smoothing)
            content["rows"].append({"case": name, "method": method} | row)
            write_json(arguments.json, content)
    print_table(content["rows"], COLUMNS)


if __name__ == "__main__":
    main()

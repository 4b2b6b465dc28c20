"""The paper's models, gradated beside uniform: forces, stresses, K and kink angles.

Runs the campaigns of examples/paper_1 to paper_3 in a folder, voxels and edges --factor times as long, and
compares what was solved on the two meshes of an increment.
"""

import argparse
import csv
import subprocess
import sys
from pathlib import Path

import numpy as np
import yaml
from measure import print_table, write_json
from paper_fields import largest_stress, read_table, shells, square, stresses_off
from paper_pictures import draw

from craftmesh.io.json_file import read_json

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES = ("paper_1", "paper_2", "paper_3")
LENGTHS = ("l_min", "l0", "l_max")
# Front edges at the ends of a front that are left out: K has no meaning at a free face.
END = 2.0
COLUMNS = {
    "increment": "increment",
    "elements": "elements uniform/gradated",
    "fewer": "fewer %",
    "unknowns": "unknowns",
    "solve_s": "solve CPU s",
    "force": "force off %",
    "stress": "stress off %: median/95%",
    "largest": "largest 1 % off %",
    "K": "K off %: mean/max",
    "kink": "kink angle off: mean/95%/max",
    "probe": "probed stress off %: mean/max",
}


def campaign(example: str, factor: float, folder: Path, name: str = "config", **more) -> Path:
    """Write an example's configuration, `more` in it and lengths `factor` times as long; return it."""
    config = yaml.safe_load((ROOT / "examples" / example / "config.yaml").read_text())
    shape = np.array(config["generate"]["shape"])
    fewer = np.round(shape / factor).astype(int)
    spacing = np.array(config["generate"]["spacing"]) * shape / fewer
    config["generate"] |= {"shape": fewer.tolist(), "spacing": spacing.tolist()}
    config["sizing"] |= {key: factor * config["sizing"][key] for key in LENGTHS}
    with open(ROOT / more.pop("cases", config["cases"]), encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream, delimiter="\t"))
    for row in rows:
        row |= {key: factor * float(row[key]) for key in row if key.removeprefix("sizing.") in LENGTHS}
    config |= {"cases": str(folder / f"{name}.tsv"), "results": str(folder)}
    config |= {key: config.get(key, {}) | own for key, own in more.items()}
    with open(config["cases"], "w", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, list(rows[0]), delimiter="\t", lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    path = folder / f"{name}.yaml"
    path.write_text(yaml.safe_dump(config))
    return path


def solved(config: Path, cores: int, targets: list[str]) -> None:
    """Run a campaign's jobs up to the targets."""
    snakemake = str(Path(sys.executable).parent / "snakemake")
    command = [snakemake, *targets, "--cores", str(cores), "--configfile", str(config)]
    subprocess.run(command, cwd=ROOT, check=True)


def both_meshes(example: str, factor: float, folder: Path, cores: int) -> list[tuple[Path, Path]]:
    """Run an example; return the folders of its increments, of the uniform mesh and of the gradated one."""
    config = campaign(example, factor, folder)
    if example != "paper_3":
        pair = (folder / "uniform" / "000", folder / "gradated" / "000")
        wanted = "sif.csv" if example == "paper_2" else "solution.vtu"
        solved(config, cores, [str(one / name) for one in pair for name in (wanted, "quality.json")])
        return [pair]
    solved(config, cores, ["all"])
    more = yaml.safe_load((ROOT / "examples/paper_3/uniform.yaml").read_text())
    of_gradated = more["cracks"]["of_gradated"]
    files = [folder / Path(file).relative_to("results/paper_3") for file in of_gradated["increments"]]
    of_gradated["increments"] = [str(file) for file in files]
    solved(campaign(example, factor, folder, "uniform", **more), cores, ["intensities", "all"])
    return [(folder / "uniform" / file.parent.name, file.parent) for file in files]


def compared(uniform: Path, gradated: Path) -> dict:
    """Return a row of the table for the folders of one increment's two meshes."""
    pair = (uniform, gradated)
    quality = [read_json(one / "quality.json") for one in pair]
    config = read_json(uniform.parent / "case.json")["config"]
    edge, cracked = config["sizing"]["l_min"], (uniform / "sif.csv").exists()
    row = {
        "increment": uniform.name,
        "elements": [one["elements"] for one in quality],
        "fewer": 100 * (1 - quality[1]["elements"] / quality[0]["elements"]),
        "unknowns": [one["dof_second_order" if cracked else "dof"] for one in quality],
        "solve_s": [cpu_seconds(one) for one in pair],
        "force": 100 * (force(gradated) / force(uniform) - 1),
    }
    if cracked:
        fronts = [read_table(one / "sif.csv") for one in pair]
        row |= along_fronts(*fronts)
        places = square(read_table(uniform / "front.csv"), edge)
    else:
        places = shells(ROOT / config["generate"]["voids_from"], config, edge)
    stresses = [largest_stress(one / "solution.vtu", places) for one in pair]
    return row | stresses_off(*stresses)


def cpu_seconds(increment: Path) -> float:
    """Return the CPU seconds of solution and K, as Snakemake sampled them."""
    found = 0.0
    for name in ("solution", "fracture"):
        path = increment.parents[1] / "benchmarks" / increment.parent.name / increment.name / f"{name}.tsv"
        if path.exists():
            with open(path, encoding="utf-8") as stream:
                found += sum(float(row["cpu_time"]) for row in csv.DictReader(stream, delimiter="\t"))
    return found


def force(increment: Path) -> float:
    """Return the force that moves the body's far plane."""
    with np.load(increment / "solution.npz") as solution:
        axis = np.abs(solution["reactions"]).sum(axis=0).argmax()
        force, moved = solution["reactions"][:, axis], np.abs(solution["displacement"][:, axis])
    return float(abs(force[moved > moved[force != 0].max() / 2].sum()))


def along_fronts(uniform: dict, gradated: dict) -> dict:
    """Return how far K, kink angles and probed stresses are off at the same places; ends are left out."""
    s, other = (one["s"] / one["s"][-1] for one in (uniform, gradated))
    end = END * max(np.median(np.diff(one)) for one in (s, other))
    inner = (s > end) & (s < 1 - end)

    def off(key: str) -> np.ndarray:
        return np.abs(np.interp(s, other, gradated[key]) - uniform[key])[inner]

    k = np.max([off(f"K_{mode}") for mode in ("I", "II", "III")], axis=0) / np.max(np.abs(uniform["K_I"]))
    row = {"K": [100 * float(k.mean()), 100 * float(k.max())]}
    if "kink_angle" in gradated:
        row["kink"] = [
            float(v) for v in (off("kink_angle").mean(), *np.percentile(off("kink_angle"), (95, 100)))
        ]
    if "probe_stress" in gradated:
        part = 100 * off("probe_stress") / uniform["probe_stress"][inner]
        row["probe"] = [float(np.nanmean(part)), float(np.nanmax(part))]
    return row


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("example", choices=EXAMPLES)
    parser.add_argument("folder", type=Path, help="for all results; goes on where it stopped")
    parser.add_argument(
        "--factor", type=float, default=2.0, help="of voxels and edges (default 2; 1: the paper's)"
    )
    parser.add_argument("--cores", type=int, default=2, help="of the campaigns (default 2)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures to this file")
    parser.add_argument(
        "--pictures",
        type=Path,
        metavar="FOLDER",
        help="draw the paper's Figs. 13 to 16, of a cracked model",
    )
    arguments = parser.parse_args()
    folder = arguments.folder.absolute()
    folder.mkdir(parents=True, exist_ok=True)
    pairs = both_meshes(arguments.example, arguments.factor, folder, arguments.cores)
    rows = [compared(*pair) for pair in pairs]
    write_json(arguments.json, {"rows": rows})
    if arguments.pictures:
        draw(pairs, rows, arguments.pictures)
    print_table(rows, COLUMNS)


if __name__ == "__main__":
    main()

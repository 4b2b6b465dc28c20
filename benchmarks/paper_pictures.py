"""Figures 13 to 16 of the gradation paper, of the increments of a crack on uniform and gradated meshes."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from paper_fields import (
    PLACES,
    WIDTH,
    arc,
    differences,
    largest_principal,
    largest_stress,
    read_table,
    square,
    stress_at,
)

from craftmesh.io.json_file import read_json
from craftmesh.report.pictures import new_figure

MESHES = ("uniform", "gradated")
SHOWN = 10.0  # % of the mean stress at which the scale of differences ends
ARC = 3.0  # radius of the arc on which the tangential stress is probed, in front edges

Pair = tuple[Path, Path]  # the folders of an increment, of its uniform and of its gradated mesh


def draw(pairs: Sequence[Pair], rows: Sequence[dict], folder: Path) -> None:
    """Write cracks.png (Fig. 13), stress.png (14), fields.png (15) and cost.png (16)."""
    folder.mkdir(parents=True, exist_ok=True)
    shown = [pairs[i] for i in sorted({0, len(pairs) // 2, len(pairs) - 1})]
    figures = {
        "cracks": crack_faces(shown),
        "stress": stress_on_plane(shown),
        "fields": fields(*pairs[-1]),
        "cost": cost(rows),
    }
    for name, figure in figures.items():
        figure.savefig(folder / f"{name}.png")


def shortest_edge(increment: Path) -> float:
    """Return the edge length at the front that the case asks for."""
    return read_json(increment.parent / "case.json")["config"]["sizing"]["l_min"]


def panels(pairs: Sequence[Pair], height: float):
    """Return a figure, its axes (2, n) with titles, and whose they are: gradated ones, then uniform."""
    figure = new_figure(3.4 * len(pairs), height)
    grid = figure.subplots(2, len(pairs), squeeze=False, sharex=True, sharey=True)
    shown = [pair[which] for which in (1, 0) for pair in pairs]
    for axes, one in zip(grid.ravel(), shown):
        axes.set_title(f"{one.parent.name}, increment {int(one.name)}", fontsize=8)
    return figure, grid, shown


def crack_faces(pairs: Sequence[Pair]):
    """Return the crack's facets from above, by the mean length of their edges; gradated meshes first."""
    from pyvista import read

    figure, grid, shown = panels(pairs, 5.2)
    for axes, one in zip(grid.ravel(), shown):
        mesh = read(one / "gradated.vtp")
        facets = mesh.regular_faces[mesh.cell_data["crack"] > 0]
        corners = mesh.points[facets]
        edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean(axis=1)
        image = axes.tripcolor(
            *mesh.points[:, :2].T, triangles=facets, facecolors=edges, edgecolors="k", lw=0.15
        )
        image.set_clim(0.8 * shortest_edge(one), 2.4 * shortest_edge(one))
        axes.set_aspect("equal")
        low, high = mesh.points[facets.ravel(), :2].min(axis=0), mesh.points[facets.ravel(), :2].max(axis=0)
        axes.set(xlim=(low[0] - 1, high[0] + 1), ylim=(low[1] - 1, high[1] + 1))  # the last crack's, shared
    figure.colorbar(image, ax=grid, label="edge length", shrink=0.7)
    return figure


def stress_on_plane(pairs: Sequence[Pair]):
    """Return maps of the largest principal stress in the plane x = the middle; gradated meshes first."""
    config = read_json(pairs[0][0].parent / "case.json")["config"]["generate"]
    box = np.multiply(config["shape"], config["spacing"])
    steps = [np.linspace(0.001, 0.999, 240) * length for length in box[1:]]
    places = np.stack(np.meshgrid([box[0] / 2], *steps, indexing="ij"), axis=-1).reshape(-1, 3)
    figure, grid, shown = panels(pairs, 5.6)
    maps = [largest_stress(one / "solution.vtu", places).reshape(240, 240).T for one in shown]
    style = {"extent": (0, box[1], 0, box[2]), "vmin": 0, "vmax": 2.5 * np.nanmedian(maps[0])}
    for axes, stress in zip(grid.ravel(), maps):
        image = axes.imshow(stress, origin="lower", cmap="turbo", **style)
    figure.colorbar(image, ax=grid, label="largest principal stress [MPa]", shrink=0.7)
    return figure


def fields(uniform: Path, gradated: Path):
    """Return kink angles along both fronts, differences of stress across their middle, stress on an arc."""
    edge = shortest_edge(uniform)
    figure = new_figure(12.0, 3.4)
    angles, plane, probed = figure.subplots(1, 3)
    front = read_table(uniform / "front.csv")
    around, on_arc, along = arc(front, ARC * edge)
    places, largest = np.concatenate([on_arc, square(front, edge)]), []
    for one, name, line in zip((uniform, gradated), MESHES, ("-", "--")):
        table = read_table(one / "sif.csv")
        angles.plot(table["s"] / table["s"][-1], table["kink_angle"], line, label=name, lw=1)
        stress = stress_at(one / "solution.vtu", places)
        tangential = np.einsum("ni,nij,nj->n", along, stress[: len(on_arc)], along)
        probed.plot(around, tangential, line, label=name, lw=1)
        largest.append(largest_principal(stress[len(on_arc) :]))
    angles.set_xlabel("place along the front, share of its length")
    angles.set_ylabel("kink angle [degrees]")
    probed.set_xlabel("angle from straight ahead [degrees]")
    probed.set_ylabel("tangential stress [MPa]")
    angles.legend()
    half = WIDTH * edge / 2
    shown = differences(*largest).reshape(round(PLACES**0.5), -1).T
    image = plane.imshow(shown, origin="lower", extent=(-half, half, -half, half), vmin=0, vmax=SHOWN)
    figure.colorbar(image, ax=plane, label="difference of principal stress [% of its mean]")
    plane.set_xlabel("ahead of the front")
    figure.tight_layout()
    return figure


def cost(rows: Sequence[dict]):
    """Return bars of unknowns and of CPU seconds of solution and K, by increment."""
    figure = new_figure(7.0, 3.0)
    for axes, key, label in zip(
        figure.subplots(1, 2), ("unknowns", "solve_s"), ("unknowns", "solution and K [CPU s]")
    ):
        for which, name in enumerate(MESHES):
            heights = [row[key][which] for row in rows]
            axes.bar(np.arange(len(rows)) + 0.4 * which, heights, 0.4, label=name)
        axes.set_xticks(np.arange(len(rows)) + 0.2, [str(int(row["increment"])) for row in rows])
        axes.set_xlabel("increment")
        axes.set_ylabel(label)
        axes.legend()
    figure.tight_layout()
    return figure

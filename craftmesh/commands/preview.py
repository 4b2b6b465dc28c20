"""Show a crack in its microstructure before it is meshed: the grains it crosses, or why it is rejected."""

import argparse
from collections.abc import Iterator
from pathlib import Path

from craftmesh.atomic import atomic_path
from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.mesh_flags import add_sizing, check_sizing, sizing_from
from craftmesh.commands.stage_io import add_output, add_report
from craftmesh.cracks.crack_surface_intersections import Oblique, oblique, traces
from craftmesh.errors import CraftmeshError, existing
from craftmesh.insertion.insert import insert_crack
from craftmesh.insertion.options import InsertOptions
from craftmesh.io.json_file import write_json
from craftmesh.io.vtk import read_crack, read_surface
from craftmesh.report.preview import Preview, front_lines, grain_measures, met_grains, preview_picture
from craftmesh.types import BOX_PLANES, Surface

OBLIQUE = 10.0  # degrees: smaller angles between crack and boundary leave little room for tetrahedra


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("surface", type=Path, help="surface .vtp before the crack is inserted")
    parser.add_argument("crack", type=Path, help="crack .vtp")
    add_output(parser, "picture .png")
    add_report(parser)
    add_sizing(parser)
    add_options(parser, InsertOptions)


def run(arguments: argparse.Namespace) -> int:
    check_sizing(arguments)
    surface = read_surface(existing(arguments.surface))
    preview = preview_crack(arguments, surface)
    for line in sentences(preview):
        print(line)
    with atomic_path(arguments.output) as temporary:
        temporary.write_bytes(preview_picture(preview, OBLIQUE))
    if arguments.report:
        write_json(arguments.report, _numbers(preview))
    return 1 if preview.refused else 0


def preview_crack(arguments: argparse.Namespace, surface: Surface) -> Preview:
    """Return a preview of the crack in a surface, from an insertion whose surface is not written.

    If the insertion raises CraftmeshError, the preview has its reason in `refused`.
    """
    crack = read_crack(existing(arguments.crack))
    found = traces(crack, surface)
    inserted, refused = None, ""
    try:
        sizing = sizing_from(arguments, surface, arguments.crack)
        inserted, _ = insert_crack(surface, crack, sizing, options_from(arguments, InsertOptions))
    except CraftmeshError as error:
        refused = " ".join(str(error).split())
    area, front_length = grain_measures(inserted) if inserted else ({}, {})
    return Preview(
        crack=crack,
        box=surface.box,
        traces=found,
        inserted=inserted,
        refused=refused,
        grains=tuple(area) if inserted else met_grains(found, surface),
        area=area,
        front_length=front_length,
        fronts=front_lines(inserted) if inserted else (),
        oblique=tuple(oblique(found, surface, OBLIQUE)),
    )


def sentences(preview: Preview) -> Iterator[str]:
    """Yield the lines that a preview prints."""
    if preview.refused:
        yield f"refused: {preview.refused}"
        yield f"grains at the boundaries that it crosses: {', '.join(map(str, preview.grains)) or 'none'}"
    for grain in preview.grains if not preview.refused else ():
        front = preview.front_length[grain]
        ends = f"front {front:.4g} long" if front else "no front: the crack cuts it through"
        yield f"grain {grain}: area {preview.area[grain]:.4g}, {ends}"
    for number, (closed, length, faces) in enumerate(preview.fronts, 1):
        where = "closed" if closed else f"from {' to '.join(faces)}"
        yield f"front {number}: {where}, {length:.4g} long"
    if preview.inserted and not preview.fronts:
        yield "no front: the crack severs the body"
    for one in preview.oblique:
        place = ", ".join(f"{x:.4g}" for x in one.place)
        yield f"{_between(one)} is met at {one.angle:.2g} degrees near ({place}), over {one.length:.4g}"


def _between(one: Oblique) -> str:
    if 0 < one.kind <= len(BOX_PLANES):
        return f"the box face {BOX_PLANES[one.kind - 1]}"
    names = [
        f"void {-side}" if side < 0 else "the outside" if side == 0 else f"grain {side}"
        for side in one.sides
    ]
    return f"the boundary of {names[1]} and {names[0]}"


def _numbers(preview: Preview) -> dict:
    return {
        "refused": preview.refused or None,
        "grains": {
            g: {"area": preview.area.get(g), "front_length": preview.front_length.get(g)}
            for g in preview.grains
        },
        "fronts": [
            {"closed": closed, "length": length, "ends": list(ends)}
            for closed, length, ends in preview.fronts
        ],
        "oblique": [one._asdict() for one in preview.oblique],
    }

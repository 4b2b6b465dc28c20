"""Who imports whom: no stage knows another stage, formats know types alone, no circle of rooms.

Imports inside functions count too. The lists of docs/architecture.md are those of the tree.
"""

import re
from graphlib import TopologicalSorter

import pytest
from package_sources import ROOT, imports_of, modules, source

GROUND = {
    "types",
    "shown",
    "arguments",
    "errors",
    "extras",
    "options",
    "progress",
    "atomic",
    "bytecode",
    "wheel_code",
    "jit",
    "kernel_code",
    "kernel_structs",
    "cli",
}
THINGS = {"voxels", "cracks", "surface", "mesh"}
WISHES = {"sizing", "mechanics"}
STAGES = {"remeshing", "stitching", "insertion", "gradation", "tetrahedra", "assembly", "deck"}
STAGES |= {"solve", "fracture", "growth", "renewal"}
RIM = {"io", "processes", "campaign", "report", "commands"}
SHARED_KERNELS = {"surface", "mesh"}
# What a room may import beside itself and the ground.
MAY_IMPORT = (
    dict.fromkeys(GROUND | {"io", "processes"}, set())
    | dict.fromkeys(THINGS, THINGS)
    | {"voxels": THINGS | {"mechanics"}}  # they carry orientations
    | dict.fromkeys(WISHES, THINGS | WISHES)
    | dict.fromkeys(STAGES, THINGS | WISHES)
    | {"tetrahedra": THINGS | WISHES | {"processes"}}
    | dict.fromkeys(("campaign", "report"), THINGS | WISHES | STAGES | RIM - {"commands"})
    | {"commands": THINGS | WISHES | STAGES | RIM}
)
# Single modules that may do more than their room: the stage `import`, and the command line's face.
MODULES_MAY_IMPORT = {
    "craftmesh.voxels.reading": {"io"},
    "craftmesh.voxels.remapping": {"io"},
    "craftmesh.voxels.file_orientations": {"io"},
    "craftmesh.cli": {"commands", "processes"},
    # one stage made of stages: the mesh before, with a part that goes through them
    "craftmesh.renewal.renew": {"insertion", "gradation", "tetrahedra", "assembly"},
}


def room(module: str) -> str:
    return module.split(".")[1]


def imports() -> list[tuple[str, str]]:
    """Return all pairs (importer, imported) of the package's modules; no import is relative."""
    return [(name, target) for name in modules() for target in imports_of(name) if "." in target]


def is_allowed(importer: str, imported: str) -> bool:
    if room(importer) == room(imported):
        return True
    if ".kernels." in imported and room(imported) not in SHARED_KERNELS:
        return False
    allowed = MAY_IMPORT[room(importer)] | MODULES_MAY_IMPORT.get(importer, set())
    return room(imported) in allowed | GROUND - {"cli"}


def test_every_room_has_its_place():
    rooms = {room(name) for name in modules()}
    assert rooms <= GROUND | THINGS | WISHES | STAGES | RIM


def test_modules_import_what_their_layer_admits():
    breaches = {pair for pair in imports() if not is_allowed(*pair)}
    assert breaches == set(), "imports against the layers"


def test_no_circle_of_rooms():
    graph: dict[str, set[str]] = {}
    for importer, imported in imports():
        if room(importer) != room(imported):
            graph.setdefault(room(importer), set()).add(room(imported))
    assert list(TopologicalSorter(graph).static_order())  # raises CycleError, which names the rooms


def test_compiled_functions_lie_in_folders_named_kernels():
    assert {name for name in modules() if "njit" in source(name)} == {"craftmesh.jit"}, "take its @kernel"
    assert all(".kernels." in name for name in modules() if "\n@kernel" in source(name))


def test_the_library_and_the_benchmarks_import_no_command():
    assert "craftmesh.commands" not in (ROOT / "__init__.pyi").read_text()
    files = sorted(ROOT.parent.glob("benchmarks/**/*.py"))
    assert len(files) > 20
    assert [file.name for file in files if "craftmesh.commands" in file.read_text()] == []


PAGE = (ROOT.parent / "docs" / "architecture.md").read_text()


def table(head: str) -> dict[str, set[str]]:
    """Return of a table of the page, by the names in its first column, the names in its second."""
    rows = PAGE.split(f"| {head} |")[1].split("\n\n")[0].splitlines()[2:]
    names = (re.findall(r"`([\w/]+)`", row) for row in rows)
    return {first: set(others) for first, *others in names}


def test_the_page_lists_the_rooms_and_the_ground():
    plan = PAGE.split("```")[1]
    listed = re.findall(r"^  (\w+)/ ", plan, re.M)
    ground = re.search(r"craftmesh/\n(.*?)\n\n", plan, re.S)
    assert ground and len(listed) == len(set(listed))
    words = [line[2:46].split() for line in ground[1].splitlines()]
    assert {word for own in words for word in own} == {room(name) for name in modules()} & GROUND
    assert set(listed) == {room(name) for name in modules()} - GROUND


def test_the_page_names_all_who_import_the_rim():
    found: dict[str, set[str]] = {}
    for importer, imported in imports():
        if room(imported) in RIM and room(importer) not in RIM | {"cli"}:
            found.setdefault(room(imported), set()).add("/".join(importer.split(".")[1:]))
    assert table("outer package | imported by") == found


def test_the_page_names_the_commands_that_know_several_stages():
    known = {}
    for name in (name for name in modules() if room(name) == "commands"):
        targets = {target for target in imports_of(name) if not target.endswith(".options")}
        stages = {room(target) for target in targets if "." in target} & STAGES
        known |= {name.rpartition(".")[2]: stages} if len(stages) > 1 else {}
    assert {name: own & STAGES for name, own in table("module | stages, and what for").items()} == known


def test_words_of_the_page_are_names_in_the_package():
    """Single words, as `snap` and `FRONT_MOVED`; test_docs looks for paths."""
    sources = "\n".join(source(name) for name in modules())
    names = set(re.findall(r"\w+", sources)) | {part for name in modules() for part in name.split(".")}
    text = re.sub(r"```.*?```", "", PAGE, flags=re.S)
    assert {word for word in re.findall(r"`(\w+)`", text) if word not in names} == set()


@pytest.mark.parametrize(
    ("importer", "imported", "allowed"),
    [
        ("craftmesh.gradation.passes", "craftmesh.surface.measure", True),
        ("craftmesh.gradation.passes", "craftmesh.surface.kernels.triangles", True),
        ("craftmesh.gradation.passes", "craftmesh.tetrahedra.record", False),
        ("craftmesh.gradation.passes", "craftmesh.io.vtk", False),
        ("craftmesh.surface.measure", "craftmesh.sizing.sizing", False),
        ("craftmesh.growth.grow", "craftmesh.cracks.series", True),
        ("craftmesh.growth.grow", "craftmesh.insertion.insert", False),
        ("craftmesh.commands.gradate", "craftmesh.gradation.kernels.star", False),
        ("craftmesh.io.vtk", "craftmesh.types", True),
        ("craftmesh.io.vtk", "craftmesh.mesh.quality", False),
        ("craftmesh.types", "craftmesh.cli", False),
    ],
)
def test_the_rule_itself(importer, imported, allowed):
    assert is_allowed(importer, imported) == allowed

"""The command line: `craftmesh VERB ...`, one verb a stage."""

import importlib
import importlib.metadata
import keyword
import sys

from craftmesh.errors import CraftmeshError

VERBS = {
    "generate": "make a synthetic polycrystal with voids and embedded grains",
    "import": "read and clean a labelled microstructure; find voids and embedded grains",
    "remesh": "turn the labelled volume into one conformal, smoothed surface",
    "crack": "make the crack surface of one increment",
    "size": "make the sizing function of one increment for all stages",
    "stitch": "join surfaces, insert the crack and clean the result",
    "gradate": "fit the surface's edges to the sizing function around the crack front",
    "tetrahedralize": "fill the grains with tetrahedra",
    "assemble": "merge the grains' tetrahedra and open the crack",
    "inp": "write the complete Abaqus and CalculiX input deck",
    "export": "write the mesh with its sets as .vtu, .msh or Exodus",
    "check": "say each breach of a stage file's invariants; measure the mesh",
    "report": "put tables and histograms of all increments on one page",
    "import-config": "turn craftmesher's config.xml into a configuration",
    "snakefile": "say where the Snakemake workflow is installed",
}

INTERRUPTED = 130


def main(argv: list[str] | None = None) -> int:
    """Run one verb and return the exit status; errors are one line on stderr, without a traceback."""
    argv = sys.argv[1:] if argv is None else argv
    try:
        return run(argv)
    except CraftmeshError as error:
        return fail(str(error))
    except KeyboardInterrupt:
        return fail("interrupted; nothing was written", INTERRUPTED)
    except MemoryError:
        return fail("out of memory; take larger sizes, more chunks or fewer workers")
    except BrokenPipeError:
        return fail("the program that read the output has ended")
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        return fail(f"{where}{error.strerror or error}")


def run(argv: list[str]) -> int:
    """Parse `argv` and run its verb; only that verb's modules are imported."""
    if not argv or argv[0] in ("-h", "--help"):
        print(overview())
        return 0
    if argv[0] == "--version":
        print("craftmesh", importlib.metadata.version("craftmesh"))
        return 0
    verb, *rest = argv
    if verb not in VERBS:
        raise CraftmeshError(f"{verb!r} is not a verb; expected one of {', '.join(VERBS)}")
    from craftmesh.commands.flags import Parser

    module = importlib.import_module(
        "craftmesh.commands." + verb.replace("-", "_") + "_" * keyword.iskeyword(verb)
    )
    parser = Parser(prog=f"craftmesh {verb}", description=module.__doc__)
    module.add_arguments(parser)
    return module.run(parser.parse_args(rest)) or 0


def overview() -> str:
    """Return the help of the whole command: the verbs in the order of the way."""
    lines = [
        "usage: craftmesh VERB ...   (craftmesh VERB --help for its options)",
        "",
        "From a labelled microstructure and a crack to gradated tetrahedral finite-element models.",
        "The stages, in the order of the way:",
        "",
    ]
    return "\n".join(lines + [f"  {verb:<15} {text}" for verb, text in VERBS.items()])


def fail(message: str, status: int = 1) -> int:
    print("craftmesh: error:", " ".join(message.split()), file=sys.stderr)
    return status


if __name__ == "__main__":
    sys.exit(main())

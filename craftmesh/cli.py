"""The command line: `craftmesh SUBCOMMAND ...`, one subcommand for each stage."""

import gc
import importlib
import sys
import time
from types import ModuleType

from craftmesh.commands.verbs import COMMANDS, VERBS, module_name, summary
from craftmesh.errors import INTERRUPTED, CraftmeshError
from craftmesh.processes.costs import asked_costs, write_costs
from craftmesh.processes.warm import serve, status_of


def main(argv: list[str] | None = None) -> int:
    """Run one subcommand and return the exit status; an error is one line on stderr, without a traceback.

    argv: the words after `craftmesh`; None: the words of the command line. Only then, a running server
    process (`processes/warm`), which has the modules loaded, runs the subcommand instead.
    """
    began = time.monotonic()
    try:
        status = status_of(sys.argv[1:]) if argv is None else None
        if status is None:
            costs = asked_costs()
            status = run(sys.argv[1:] if argv is None else argv)
            if costs and not status:
                write_costs(costs, began)
        return status
    except CraftmeshError as error:
        return fail(str(error))
    except KeyboardInterrupt:
        return fail("interrupted; nothing was written", INTERRUPTED)
    except MemoryError:
        return fail("out of memory; use larger edge lengths, more chunks or fewer workers")
    except BrokenPipeError:
        return fail("the program that read the output has ended")
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        return fail(f"{where}{error.strerror or error}")


def run(argv: list[str]) -> int:
    """Parse `argv`, run its subcommand and return the exit status; import only that subcommand's modules.

    Without words, or with -h or --help, print the overview; with --version print the version.
    """
    if not argv or argv[0] in ("-h", "--help"):
        print(overview())
        return 0
    if argv[0] == "--version":
        print("craftmesh", importlib.import_module("importlib.metadata").version("craftmesh"))
        return 0
    verb, *rest = argv
    if verb not in VERBS:
        near = importlib.import_module("difflib").get_close_matches(verb, VERBS, 1)
        hint = f"did you mean {near[0]}?" if near else f"known: {', '.join(VERBS)}"
        raise CraftmeshError(f"unknown subcommand {verb!r}; {hint}")
    module = load(verb)
    from craftmesh.commands.flags import Parser

    parser = Parser(prog=f"craftmesh {verb}", description=module.__doc__)
    module.add_arguments(parser)
    return module.run(parser.parse_args(rest)) or 0


def load(verb: str) -> ModuleType:
    """Import and return a subcommand's module, with garbage collection off: imports leave no garbage."""
    gc.disable()
    try:
        return importlib.import_module(f"{COMMANDS}.{module_name(verb)}")
    finally:
        gc.freeze()
        gc.enable()


def serve_verbs(number: int) -> None:
    """Run the subcommands that clients send over the socket with the file descriptor `number`."""
    serve(number, main, load)


def overview() -> str:
    """Return the help of the whole command: the subcommands in the order of `VERBS`."""
    lines = [
        "usage: craftmesh SUBCOMMAND ...   (craftmesh SUBCOMMAND --help for its options)",
        "",
        "From a labelled microstructure and a crack to gradated tetrahedral finite-element models.",
        "The subcommands, in the order of a campaign:",
        "",
    ]
    return "\n".join(lines + [f"  {verb:<15} {summary(verb)}" for verb in VERBS])


def fail(message: str, status: int = 1) -> int:
    """Print `message` as one line on stderr and return `status`."""
    print("craftmesh: error:", " ".join(message.split()), file=sys.stderr)
    return status


if __name__ == "__main__":
    sys.exit(main())

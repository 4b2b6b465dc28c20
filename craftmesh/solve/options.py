"""How the field is found."""

from dataclasses import dataclass

from craftmesh.options import Options, option

BUILTIN, CALCULIX, ABAQUS, EXTERNAL = "builtin", "calculix", "abaqus", "external"


@dataclass(frozen=True)
class SolveOptions(Options):
    """Which solver finds the field, how exact it is, and what it may take."""

    solver: str = option(
        BUILTIN,
        "builtin; calculix or abaqus, programs run on the deck; external, a file that is waited for",
        choices=(BUILTIN, CALCULIX, ABAQUS, EXTERNAL),
    )
    tolerance: float = option(
        1e-8, "builtin's largest residual: forces out of balance over reactions and loads", above=0, below=1
    )
    max_iterations: int = option(
        500, "builtin: a field that is not exact enough by then is refused", at_least=1
    )
    integration: str = option(
        "deck",
        "builtin: points at which C3D10 are integrated: deck, the 4 of Abaqus and CalculiX; full, 14, with "
        "which quarter points carry uniform strain exactly too",
        choices=("deck", "full"),
    )
    command: tuple[str, ...] = option(
        (),
        "in place of the calls of calculix or abaqus, each a text with {job}, {script} and {field}",
    )
    time_limit: float = option(86400.0, "longest time for each call of a program", "s", above=0)
    memory_limit: float = option(
        16.0,
        "largest memory that builtin may take, as estimated, or a program's address space",
        "GB",
        above=0,
    )

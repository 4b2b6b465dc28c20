"""What the page holds cases of several element sizes against."""

from dataclasses import dataclass

from craftmesh.options import Options, option

# Quantities of a case with one size, by name: what each is in words.
QUANTITIES = {
    "K_I": "mean K_I along the fronts",
    "J": "mean J along the fronts",
    "kink_angle": "mean kink angle, its sign left out [degrees]",
    "largest_K_I": "largest K_I along the fronts, their ends left out",
    "reaction": "force that the supports carry",
    "crack_area": "area of the crack",
    "mean_aspect_ratio": "mean aspect ratio of the elements",
    "elements": "number of elements",
}
# The unit of each, of those that UnitsOptions knows.
MEASURED_IN = {"K_I": "K", "largest_K_I": "K", "J": "J", "reaction": "force", "crack_area": "area"}
SOLVED = ("K_I", "J", "kink_angle", "largest_K_I", "reaction")


@dataclass(frozen=True)
class ReportOptions(Options):
    """What is compared where cases differ in an element size alone, and when it has converged."""

    quantity: str | None = option(
        None,
        "quantity of a sweep over element sizes, solved where it asks for that; none: all that are there",
        choices=tuple(QUANTITIES),
    )
    tolerance: float = option(
        0.05, "a size has converged where it and all finer ones are within this of the finest", above=0
    )

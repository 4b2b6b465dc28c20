"""How far a crack came, increment by increment, and why it goes no further."""

from collections.abc import Mapping

import numpy as np


def increment_numbers(rows: Mapping[str, np.ndarray], growth: Mapping | None) -> dict:
    """Return the extremes along a crack's fronts, and where it has grown, by how much.

    rows: columns of sif.csv; growth: a growth.json, None where nothing follows the increment.
    """
    k_1, kink = rows["K_I"], rows["kink_angle"]
    numbers = {
        "least_K_I": float(np.nanmin(k_1)),
        "largest_K_I": float(np.nanmax(k_1)),
        "least_kink_angle": float(np.nanmin(kink)),
        "largest_kink_angle": float(np.nanmax(kink)),
    }
    if growth is not None and not growth["ended"]:
        numbers["least_extension"], numbers["largest_extension"] = growth["extension"]
    return numbers


def outcome(growths: Mapping[str, Mapping], increments: int) -> str:
    """Return in a sentence how far a crack came.

    growths: growth.json by increment; increments: how many there are.
    """
    stopped = [(name, growth["ended"]) for name, growth in growths.items() if growth["ended"]]
    if stopped:
        name, why = stopped[0]
        return f"The crack stops after increment {name}: {why}."
    return f"{increments} increments, as many as were asked for."

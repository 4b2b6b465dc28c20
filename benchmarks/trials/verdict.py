"""What is a fault: the limits of every check, in one place."""

import math

FRONT = 0.02  # l_min: front nodes off the given curve
FACET = 0.15  # l_min: nodes of the crack, and middles of its facets and edges, off the given surface
AREA = 0.5  # percent of the given area within the box
LEAST_AREA = 0.02  # l_min squared: less counts for no crack; one of two facets has it at its rim
MISSING = 1.0  # l_min: the given front that is not there; a chord of two l_min on a tight bend is 0.5 off
DRIFT_LARGE = 5.0  # percent, grains over 500 voxels
NO_FRONT = "no front in the material"
OUTSIDE = "outside the material"
GOAL = {"ar_under_5_pct": 99.95, "poor_pct": 0.01}
# whose work mends it: the room of the package
ROOM = {
    "crash": "any",
    "refused": "insertion",
    "refused late": "cracks",
    "front": "front",
    "front missing": "front",
    "front set": "front",
    "crack nodes": "gradation",
    "facets": "insertion",
    "area": "insertion",
    "wedge": "gradation",
    "flat": "tetrahedra",
    "inverted": "tetrahedra",
    "grain failed": "tetrahedra",
    "volume": "gradation",
    "conformity": "assembly",
    "judge": "any",
}


def faults_of(row: dict) -> dict[str, str]:
    """Return the faults of a row by check, each in a few words; an empty dict is a sound row."""
    if row["outcome"] == "refusal":
        said = f"{row['stage']}: {row['message']}"
        if row["may_be_refused"] is None:
            return {"refused": said}
        return {"refused late": f"{row['may_be_refused']}, {said}"} if row["stage"] != "crack" else {}
    failed = [warning for warning in row["warnings"] if warning.startswith("meshing: ")]
    found: dict[str, str] = {"grain failed": failed[0]} if failed else {}
    if not row["front_edges"]:
        severed = row["may_be_refused"] in (NO_FRONT, OUTSIDE) or row.get("front_inside", math.inf) <= FRONT
        if not severed:  # the body, or a corner of it, has no front
            found["front missing"] = "no front in the deck"
    else:
        found |= _crack_faults(row)
    if row["wedges_made"]:
        found["wedge"] = (
            f"{row['wedges_made']} made, {row['made_wedge']:.2f} degrees from {row['made_from']:.2f} "
            f"in grain {row['made_in']} at {row['made_at']}"
        )
    if row["flat_unforced"]:
        low, high, shape = row["flat_worst"]
        found["flat"] = (
            f"{row['flat_unforced']} unforced, worst {low:.2f}/{high:.2f} degrees, shape {shape:.4f} in "
            f"grain {row['flat_in']} at {row['flat_at']}; wedges there: input {row['flat_wedges'][0]:.1f}, "
            f"gradated {row['flat_wedges'][1]:.1f}; least angle of the facets at it {row['flat_facet']:.1f}"
        )
    if row["inverted"]:
        found["inverted"] = f"{row['inverted']} tets of no volume"
    if row["drift_large_pct"] > DRIFT_LARGE or row["grains_lost"] or row["grains_unknown"]:
        found["volume"] = f"drift {row['drift_large_pct']:.2f} %, {row['grains_lost']} grains lost"
    keys = ("faces_over_two", "free_faces_unnamed", "named_faces_not_free", "lips_unpaired", "nodes_unused")
    torn = {key: row[key] for key in keys if row[key]}
    if torn:
        found["conformity"] = ", ".join(f"{key} {value}" for key, value in torn.items())
    if row.get("judged"):
        found["judge"] = "; ".join(row["judged"])
    return found


def _crack_faults(row: dict) -> dict[str, str]:
    found = {}
    if row["front_node"] > FRONT:
        where = " on the box" if row["front_node_on_box"] else ""
        found["front"] = f"node {row['front_node']:.3f} l_min off at {row['front_node_at']}{where}"
        found["front"] += f"; {row['inserted_front_node']:.3f} as inserted"
    if row["front_missing"] > MISSING:
        found["front missing"] = f"given front {row['front_missing']:.2f} l_min from the deck's"
    if row["front_set_off"]:
        found["front set"] = f"{row['front_set_off']} nodes differ between CRACK_FRONT and where lips meet"
    for check, key in (("crack nodes", "facet_node"), ("facets", "facet")):
        if row[key] > FACET:
            where, before = row[f"{key}_at"], row[f"inserted_{key}"]
            found[check] = f"{row[key]:.3f} l_min off the sheet at {where}; {before:.3f} as inserted"
    if row["area_off_pct"] is not None and row["area_off_pct"] > _area_allowed(row):
        found["area"] = (
            f"{row['area']:.6g} instead of {row['area_given']:.6g}, {row['area_off_pct']:.2f} % off"
        )
    return found


def _area_allowed(row: dict) -> float:
    """Return the percentage of its area by which a crack may be off; rows without l_min have no least."""
    return max(AREA, 100 * LEAST_AREA * row.get("l_min", 0.0) ** 2 / row["area_given"])

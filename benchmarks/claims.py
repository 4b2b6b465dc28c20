"""The error of K that sif.csv claims, against the true one, node by node."""

from collections.abc import Iterable

import numpy as np

LEAST = 95.0  # % of the nodes in which the claimed error has to be true
COLUMNS = {
    "case": "case",
    "load": "load",
    "edges": "a/h",
    "nodes": "nodes",
    "covered": "claimed is true %",
    "true": "true median/max %",
    "claimed": "claimed median/max %",
    "ratio": "claimed over true, median",
}


def compared(k, wanted, error) -> dict[str, list[float]]:
    """Return a node's largest true error of K (n, 3), and that claimed (n,), in % of the largest K."""
    largest = np.abs(wanted).max() / 100
    off = np.abs(k - wanted).max(axis=1)
    return {"true": (off / largest).tolist(), "claimed": (error / largest).tolist()}


def table(rows: Iterable[dict]) -> list[dict]:
    """Return a row of COLUMNS for each row that `compared` is in, and one over all nodes."""
    rows = [row for row in rows if "true" in row]
    every = {key: [share for row in rows for share in row[key]] for key in ("true", "claimed")}
    return [_figures(row) for row in (*rows, {"case": "all"} | every)]


def holds(rows: Iterable[dict]) -> bool:
    """Tell whether what is claimed is true in LEAST of all nodes."""
    return bool(table(rows)[-1]["covered"] >= LEAST)


def _figures(row: dict) -> dict:
    true, claimed = np.array(row["true"]), np.array(row["claimed"])
    if not len(true):
        return {"case": row["case"], "nodes": 0, "covered": 100.0}
    return {
        "case": row["case"],
        "load": row.get("load"),
        "edges": row.get("edges"),
        "nodes": len(true),
        "covered": float(100 * (true <= claimed).mean()),
        "true": [float(np.median(true)), float(true.max())],
        "claimed": [float(np.median(claimed)), float(claimed.max())],
        "ratio": float(np.median(claimed / np.maximum(true, np.finfo(float).tiny))),
    }

"""The site's page of speed over time, made of docs/speed.csv, to which `make bench` appends."""

import csv
from collections import defaultdict
from pathlib import Path

WIDTH, HEIGHT, EDGE = 640, 120, 30  # of a picture, in pixels
HEADS = ("date", "commit", "CPU s", "of TetGen", "ratio", "peak MB")
KEYS = ("date", "commit", "cpu_s", "tetgen_s", "ratio", "peak_mb")


def speed_page(record: Path) -> str:
    """Return the page: a picture and a table of each stage of each case on each machine."""
    with open(record, newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    series = defaultdict(list)
    for row in rows:
        series[row["machine"], row["case"], row["stage"]].append(row)
    parts = [
        "# Speed over time",
        "CPU seconds of a stage, and their ratio to those of TetGen alone on the same surface in the"
        " same process, which other work on the machine changes less. "
        "[How it is measured](how-to-benchmark.md#speed-over-time).",
    ]
    for (machine, case, stage), those in series.items():
        parts += [f"## {case}, {stage}", f"On {machine}.", picture([float(row["ratio"]) for row in those])]
        lines = ["| " + " | ".join(HEADS) + " |", "|---" * len(HEADS) + "|"]
        lines += ["| " + " | ".join(row[key] for key in KEYS) + " |" for row in those]
        parts.append("\n".join(lines))
    return "\n\n".join(parts) + "\n"


def picture(ratios: list[float]) -> str:
    """Return an SVG of ratios from the oldest to the newest, the axis from 0."""
    top = 1.1 * max(ratios)
    step = (WIDTH - 2 * EDGE) / max(1, len(ratios) - 1)
    places = [(EDGE + i * step, HEIGHT - (HEIGHT - 20) * ratio / top) for i, ratio in enumerate(ratios)]
    line = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
    dots = "".join(
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3"/><text x="{x:.1f}" y="{y - 6:.1f}">{ratio:.2f}</text>'
        for (x, y), ratio in zip(places, ratios)
    )
    return (
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" font-size="10" text-anchor="middle">'
        f'<title>ratio to TetGen</title><path d="M0 {HEIGHT}H{WIDTH}" stroke="currentColor"/>'
        f'<polyline points="{line}" fill="none" stroke="currentColor"/>{dots}</svg>'
    )

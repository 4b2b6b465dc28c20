"""Run notebooks without Jupyter, and keep in them what their cells print and draw.

    python examples/notebooks/execute.py examples/notebooks/*.ipynb

The code cells of a notebook share one namespace, as in Jupyter. Files that they write go to a folder that
is removed. Figures of matplotlib become pictures of few colours, which keeps notebooks small.
"""

import argparse
import base64
import contextlib
import io
import json
import os
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
from PIL import Image

COLOURS = 64  # of a picture
DOTS = 90  # per inch


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("notebooks", type=Path, nargs="+")
    for path in parser.parse_args().notebooks:
        notebook = json.loads(path.read_text(encoding="utf-8"))
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            execute(notebook)
        path.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        print(path)


def execute(notebook: dict) -> dict:
    """Run the code cells in the working folder, replace their outputs, and return their namespace."""
    names: dict = {"__name__": "__main__"}
    code = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    for count, cell in enumerate(code, 1):
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            exec(compile("".join(cell["source"]), f"cell {count}", "exec"), names)
        cell["execution_count"] = count
        cell["outputs"] = [*_printed(said.getvalue()), *map(_drawn, plt.get_fignums())]
        plt.close("all")
    return names


def _printed(text: str) -> list[dict]:
    lines = text.splitlines(keepends=True)
    return [{"output_type": "stream", "name": "stdout", "text": lines}] if lines else []


def _drawn(number: int) -> dict:
    """Return a figure as the output that Jupyter would make of it."""
    drawn, small = io.BytesIO(), io.BytesIO()
    plt.figure(number).savefig(drawn, format="png", dpi=DOTS, bbox_inches="tight")
    Image.open(drawn).convert("RGB").quantize(COLOURS).save(small, format="png", optimize=True)
    picture = base64.b64encode(small.getvalue()).decode()
    return {"output_type": "display_data", "data": {"image/png": picture}, "metadata": {}}


if __name__ == "__main__":
    os.environ["PYVISTA_OFF_SCREEN"] = "true"
    main()

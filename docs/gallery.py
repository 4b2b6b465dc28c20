"""The site's gallery and its pages of notebooks, made of the files of examples and notebooks."""

import base64
import json
import posixpath
import re
from pathlib import Path

PICTURE = re.compile(r"!\[[^\]]*\]\([^)]+\)")


def notebook_page(path: Path) -> tuple[str, dict[str, bytes]]:
    """Return a notebook as a page, and the pictures of its cells by their places on the site."""
    parts, pictures = [], {}
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        text = "".join(cell["source"])
        parts.append(text if cell["cell_type"] == "markdown" else f"```python\n{text}\n```")
        for output in cell.get("outputs", []):
            if "text" in output:
                parts.append(f"```text\n{''.join(output['text']).rstrip()}\n```")
            else:
                place = f"pictures/notebook-{path.stem}-{len(pictures) + 1}.png"
                pictures[place] = base64.b64decode(output["data"]["image/png"])
                parts.append(f"![what the cell draws]({place})")
    return "\n\n".join(parts) + "\n", pictures


def gallery_page(pages: dict[str, str]) -> str:
    """Return the page that has, of each of the `pages` (place -> text) with a picture, what it shows."""
    parts = ["# Gallery", "Each picture leads to the page that has its commands."]
    for place, text in pages.items():
        picture = PICTURE.search(text)
        if picture:
            title, first, *_ = (part.strip() for part in text.split("\n\n"))
            name = posixpath.basename(place)
            parts += [f"## [{title.removeprefix('# ')}]({name})", first, f"[{picture.group()}]({name})"]
    return "\n\n".join(parts) + "\n"

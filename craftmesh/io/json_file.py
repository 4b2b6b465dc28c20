"""Reading and writing of reports and records as .json objects."""

import json
import math
from pathlib import Path
from typing import Any

from craftmesh.atomic import atomic_path
from craftmesh.errors import CraftmeshError, existing


def write_json(path: Path, content: dict) -> None:
    """Write `content` completely or not at all; numbers that are not finite become null."""
    with atomic_path(path) as temporary:
        text = json.dumps(_finite(content), indent=1, allow_nan=False)
        temporary.write_text(text + "\n", encoding="utf-8")


def read_json(path: Path) -> dict:
    """Read a .json object; raises CraftmeshError for a missing file and for any other content."""
    try:
        content = json.loads(existing(path).read_text(encoding="utf-8"))
    except ValueError as error:
        raise CraftmeshError(f"{path}: not JSON ({error}); give a file written by craftmesh") from None
    if not isinstance(content, dict):
        raise CraftmeshError(f"{path}: contains a {type(content).__name__}; give a JSON object")
    return content


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(k): _finite(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(v) for v in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value

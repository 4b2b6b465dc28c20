"""Reading of users' YAML with one-line errors, also for duplicate keys."""

import codecs
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from craftmesh.errors import CraftmeshError, existing_file

# Numbers that YAML 1.1 does not read as decimal ones: 0012 as 10 and 12:30 as 750.
_OTHERWISE = re.compile(r"[-+]?(0[0-9_]|[0-9_]+:)")
_WIDE = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)


def read_yaml(path: Path) -> Any:
    """Return the content of a YAML or JSON file, None if it is empty.

    Raises CraftmeshError, with the file and often the line, for missing files, text that is not YAML in
    UTF-8, duplicate keys, and octal or sexagesimal numbers.
    """
    try:
        content = existing_file(path, "give a YAML file").read_bytes()
        if content.startswith(_WIDE):
            raise ValueError("is UTF-16")
        return parse_yaml(content.decode("utf-8-sig"), str(path))
    except OSError as error:
        raise CraftmeshError(f"{path}: cannot be read ({error.strerror}); expected YAML") from None
    except ValueError as error:
        raise CraftmeshError(f"{path}: {error}; save it as YAML in UTF-8") from None


def parse_yaml(text: str, place: str) -> Any:
    """Return the content of a text in YAML or JSON, None if it is empty.

    Raises CraftmeshError as `read_yaml`; its message begins with `place`.
    """
    import yaml

    if "\t" in text and _is_json(text):
        text = text.replace("\t", " ")
    loader = yaml.SafeLoader("")
    try:
        loader = yaml.SafeLoader(text)
        root = loader.get_single_node()
        for fault in _faults(root):
            raise CraftmeshError(f"{place}: {fault}")
        return None if root is None else loader.construct_document(root)
    except (yaml.YAMLError, ValueError, OverflowError) as error:
        line = " ".join(str(error).replace("<unicode string>", "it").split())
        advice = "; indent with spaces, not with tabs" if "'\\t'" in line else ""
        raise CraftmeshError(f"{place}: {line}; expected YAML{advice}") from None
    except RecursionError:
        raise CraftmeshError(f"{place}: an anchor contains itself; write its values out") from None
    finally:
        loader.dispose()


def _is_json(text: str) -> bool:
    try:
        json.loads(text)
    except ValueError:
        return False
    return True


def _faults(node: Any, path: str = "", above: frozenset = frozenset()) -> Iterator[str]:
    """Yield a message for each duplicate key, and each number that YAML 1.1 reads in another base.

    path: key of `node`; above: ids of the nodes above it. Raises RecursionError if a node contains itself.
    """
    import yaml

    if id(node) in above:
        raise RecursionError
    above |= {id(node)}
    if isinstance(node, yaml.ScalarNode):
        is_number = not node.style and node.tag.endswith((":int", ":float"))
        if is_number and _OTHERWISE.match(node.value):
            yield (
                f"line {_line(node)}: YAML reads {node.value} as an octal or sexagesimal number; "
                "write a decimal number, or put text in quotes"
            )
    elif isinstance(node, yaml.SequenceNode):
        for number, item in enumerate(node.value):
            yield from _faults(item, f"{path}[{number}]", above)
    elif isinstance(node, yaml.MappingNode):
        lines: dict[Any, int] = {}
        for key, value in node.value:
            inner = f"{path}.{key.value}" if path else str(key.value)
            yield from _faults(key, inner, above)
            if inner in lines:
                yield f"duplicate key {inner} on lines {lines[inner]} and {_line(key)}; keep one"
            lines[inner] = _line(key)
            yield from _faults(value, inner, above)


def _line(node: Any) -> int:
    return node.start_mark.line + 1

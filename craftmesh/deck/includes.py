"""Decks in several files: a model that includes its mesh, and any deck read with what it includes."""

import os
import re
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from craftmesh.errors import CraftmeshError, existing_file


def mesh_file(model: str | os.PathLike) -> Path:
    """Return the file beside the deck `model` that holds its mesh when the deck includes it."""
    model = Path(model)
    return model.with_name(f"{model.stem}_mesh{model.suffix}")


def include_line(model: str | os.PathLike) -> str:
    """Return the line by which the deck `model` includes its mesh, relative to the folder of both.

    Raises CraftmeshError for a name that the solvers would need quoted or not read.
    """
    name = mesh_file(model).name
    if not re.fullmatch(r"[A-Za-z0-9_.-]{1,80}", name):
        raise CraftmeshError(
            f"{model}: includes need a plain file name, and {name!r} is none; use up to 80 letters, "
            "digits, dots, hyphens and underscores"
        )
    return f"*INCLUDE, INPUT={name}\n"


@dataclass
class DeckText:
    """The text of a deck with the included files in their places, and where each line comes from."""

    text: str = ""
    breaches: list[str] = field(default_factory=list)
    starts: list[int] = field(default_factory=list)
    sources: list[tuple[str, int]] = field(default_factory=list)

    def place(self, line: int) -> str:
        """Return how to name a line of `text`: its number in the file, and the file if it is included."""
        piece = bisect_right(self.starts, line) - 1
        name, first = self.sources[piece]
        return f"{name}line {line - self.starts[piece] + first}"


def read_deck_text(path: str | os.PathLike) -> DeckText:
    """Read a deck and what it includes, names relative to the deck's folder as the solvers take them.

    Files that are not there, or that include themselves, are breaches and left out.
    """
    deck, texts, line = DeckText(), [], 1
    for name, first, text in _pieces(Path(path), "", (Path(path),), deck.breaches):
        if text:
            text = text if text.endswith("\n") else text + "\n"
            deck.starts.append(line)
            deck.sources.append((name, first))
            texts.append(text)
            line += text.count("\n")
    deck.text = "".join(texts)
    return deck


def _pieces(
    path: Path, name: str, chain: tuple[Path, ...], breaches: list[str]
) -> Iterator[tuple[str, int, str]]:
    """Yield the texts between includes: of which file, from which line on, and the text."""
    text = existing_file(path).read_bytes().decode("latin-1")
    start, line = 0, 1
    for found in re.finditer(r"^\*INCLUDE\b[^\n]*\n?", text, re.M | re.I):
        yield name, line, text[start : found.start()]
        line += text.count("\n", start, found.start())
        given = re.search(r"INPUT\s*=\s*([^,\n]*)", found.group(), re.I)
        file = chain[0].parent / (given.group(1).strip().strip("\"'") if given else "")
        if file in chain:
            breaches.append(f"{name}line {line}: {file.name} includes itself")
        elif not file.is_file():
            breaches.append(f"{name}line {line}: the included file {file.name} is not there")
        else:
            yield from _pieces(file, f"{file.name}, ", (*chain, file), breaches)
        start, line = found.end(), line + 1
    yield name, line, text[start:]


@dataclass(frozen=True)
class Block:
    """One keyword with its parameters (upper case), its data lines and its place in the deck."""

    keyword: str
    parameters: dict[str, str]
    data: str
    place: str


def read_blocks(deck: DeckText) -> list[Block]:
    """Split a deck at its keyword lines; comments are left out."""
    text = deck.text
    heads = list(re.finditer(r"^\*(?!\*)[^\n]*$", text, re.M))
    ends = [head.start() for head in heads[1:]] + [len(text)]
    blocks = []
    line, seen = 1, 0
    for head, end in zip(heads, ends):
        line += text.count("\n", seen, head.start())
        seen = head.start()
        keyword, *words = (word.strip() for word in head.group()[1:].split(","))
        pairs = (word.partition("=") for word in words if word)
        parameters = {key.strip().upper(): value.strip().upper() for key, _, value in pairs}
        data = re.sub(r"^\*\*[^\n]*\n?", "", text[head.end() + 1 : end], flags=re.M)
        blocks.append(Block(keyword.upper(), parameters, data, deck.place(line)))
    return blocks

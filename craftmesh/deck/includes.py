"""Decks in several files: a model that includes its mesh, and any deck read with its included files."""

import os
import re
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from craftmesh.errors import CraftmeshError, existing_file


def mesh_file(model: str | os.PathLike) -> Path:
    """Return the path of the mesh file that the deck `model` includes, MODEL_mesh.inp next to MODEL.inp."""
    model = Path(model)
    return model.with_name(f"{model.stem}_mesh{model.suffix}")


def include_line(model: str | os.PathLike) -> str:
    """Return the line with which the deck `model` includes its mesh, relative to the folder of both.

    Raises CraftmeshError for a file name that the solvers cannot read without quotes.
    """
    name = mesh_file(model).name
    if not re.fullmatch(r"[A-Za-z0-9_.-]{1,80}", name):
        raise CraftmeshError(
            f"{model}: includes need a plain file name, but the mesh file would be {name!r}; use up to 80 "
            "letters, digits, dots, hyphens and underscores"
        )
    return f"*INCLUDE, INPUT={name}\n"


@dataclass
class DeckText:
    """The text of a deck with the included files in place, and the source of each line.

    breaches: sentences on faulty includes. The text consists of pieces between includes: starts has the
    first line in `text` of each piece; sources has its file, "" for the deck itself, and its first line
    there.
    """

    text: str = ""
    breaches: list[str] = field(default_factory=list)
    starts: list[int] = field(default_factory=list)
    sources: list[tuple[str, int]] = field(default_factory=list)

    def place(self, line: int) -> str:
        """Return "line N" for a line of `text`, N counted in its file, after an included file's name."""
        piece = bisect_right(self.starts, line) - 1
        name, first = self.sources[piece]
        return f"{name}line {line - self.starts[piece] + first}"


def read_deck_text(path: str | os.PathLike) -> DeckText:
    """Read a deck with its included files, whose names are relative to the deck's folder, as for solvers.

    Missing included files, and files that include themselves, are left out and reported in `breaches`.
    Raises CraftmeshError if the deck itself is missing.
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
    """Yield (file, first line, text) of each piece between includes of a file, in order.

    name: the file, as in messages; chain: the deck, then the files that lead to this one, and this one.
    """
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
            breaches.append(f"{name}line {line}: the included file {file.name} does not exist")
        else:
            yield from _pieces(file, f"{file.name}, ", (*chain, file), breaches)
        start, line = found.end(), line + 1
    yield name, line, text[start:]


@dataclass(frozen=True)
class Block:
    """A keyword of a deck with its parameters and data lines.

    Keyword and parameters are in upper case; place: file and line, for messages.
    """

    keyword: str
    parameters: dict[str, str]
    data: str
    place: str


def read_blocks(deck: DeckText) -> list[Block]:
    """Split a deck into blocks at its keyword lines; comments are left out."""
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

"""Progress of long stages: they call `progress(fraction, text)`, and the caller decides how it is shown."""

import shutil
import sys
import time
from collections.abc import Sequence
from typing import Self, TextIO


def silent(fraction: float, text: str) -> None:
    """Do nothing: the default progress function of every stage."""


class ProgressLine:
    """A progress line for a terminal or log; a context manager that ends the line on exit.

    A call with a fraction 0..1 and a short text writes `stage  42% text (12 s)`. On a terminal the line is
    rewritten in place. A log gets a new line at most every `interval` seconds. Nothing is written in the
    `first` seconds.
    """

    def __init__(
        self, stage: str, stream: TextIO | None = None, first: float = 2.0, interval: float = 10.0
    ):
        self.stage = stage
        self.stream = sys.stderr if stream is None else stream
        self.is_terminal = self.stream.isatty()
        self.interval = 0.2 if self.is_terminal else interval
        self.start = time.monotonic()
        self.next = self.start + first
        self.width = 0

    def __call__(self, fraction: float, text: str) -> None:
        now = time.monotonic()
        if now < self.next:
            return
        self.next = now + self.interval
        line = f"{self.stage} {100 * fraction:3.0f}% {text} ({now - self.start:.0f} s)"
        if self.is_terminal:
            self.stream.write("\r" + line.ljust(self.width))
            self.width = len(line)
        else:
            self.stream.write(line + "\n")
        self.stream.flush()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the terminal's line, so that later output begins on a new line."""
        if self.width:
            self.stream.write("\n")
            self.stream.flush()
            self.width = 0


class LiveLines:
    """Lines that a terminal shows in one place and rewrites; a context manager that clears them on exit.

    A log gets only lines that were not among the last ones shown, at most every `interval` seconds.
    """

    def __init__(self, stream: TextIO | None = None, interval: float = 30.0):
        self.stream = sys.stderr if stream is None else stream
        self.is_terminal = self.stream.isatty()
        self.interval = interval
        self.next = 0.0
        self.shown: list[str] = []

    def show(self, lines: Sequence[str]) -> None:
        """Show `lines`; if they exceed the terminal's height, only the last ones."""
        if self.is_terminal:
            width, height = shutil.get_terminal_size()
            up = f"\x1b[{len(self.shown)}F" if self.shown else ""
            self.shown = [line[: width - 1] for line in lines[-(height - 1) :]]
            self.stream.write(up + "\x1b[J" + "".join(f"{line}\n" for line in self.shown))
        elif time.monotonic() >= self.next:
            self.next = time.monotonic() + self.interval
            self.stream.writelines(f"{line}\n" for line in lines if line not in self.shown)
            self.shown = list(lines)
        self.stream.flush()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self.is_terminal:
            self.show([])

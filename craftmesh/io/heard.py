"""What libraries log while they read a file: heard, in place of lines on stderr."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager


class _Listener(logging.Handler):
    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.said: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.said.append(record.getMessage())


@contextmanager
def heard(library: str) -> Iterator[list[str]]:
    """Yield the list that gets the warnings and errors which a library logs within."""
    listener = _Listener()
    logger = logging.getLogger(library)
    logger.addHandler(listener)
    try:
        yield listener.said
    finally:
        logger.removeHandler(listener)

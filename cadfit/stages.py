"""How long each stage of the work takes, for whoever listens: records of `logging` under the name "cadfit"."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter

_log = logging.getLogger("cadfit")


@contextmanager
def stage(name: str) -> Iterator[None]:
    """Say at level DEBUG how long the block took (as a decorator: the function), in seconds."""
    start = perf_counter()
    yield
    if _log.isEnabledFor(logging.DEBUG):
        seconds = perf_counter() - start
        _log.debug("%s: %.3f s", name, seconds, extra={"stage": name, "seconds": seconds})


class _Sums(logging.Handler):
    """Adds up the seconds of each stage."""

    def __init__(self) -> None:
        super().__init__()
        self.found: dict[str, float] = {}

    def emit(self, record: logging.LogRecord) -> None:
        name, seconds = getattr(record, "stage", None), getattr(record, "seconds", 0.0)
        if name is not None:
            self.found[name] = self.found.get(name, 0.0) + seconds


@contextmanager
def times() -> Iterator[dict[str, float]]:
    """Give the seconds of each stage of the block, summed by name, in the order of their first ends.

    >>> with times() as found, stage("resting"):
    ...     pass
    >>> list(found)
    ['resting']
    """
    sums, level = _Sums(), _log.level
    _log.addHandler(sums)
    _log.setLevel(logging.DEBUG)
    try:
        yield sums.found
    finally:
        _log.removeHandler(sums)
        _log.setLevel(level)

"""How far the work is, and how long each stage took: for who listens, records of `logging` by the name "cadfit"."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter

Progress = Callable[[float], None]  # is given the part that is done, from 0 to 1; what it raises stops the work

_log = logging.getLogger("cadfit")


def unheard(part: float) -> None:
    """Take the progress that nobody asked for."""


def portion(progress: Progress | None, low: float, high: float) -> Progress:
    """Return the progress of a part of the work, which is from `low` to `high` of the whole.

    >>> portion(print, 0.5, 1.0)(0.5)
    0.75
    """
    return unheard if progress is None else lambda part: progress(low + (high - low) * part)


def shares(progress: Progress | None, count: int) -> list[Progress]:
    """Return the progress of each of `count` equal parts of the work, in turn.

    >>> [part(0.5) for part in shares(print, 2)]
    0.25
    0.75
    [None, None]
    """
    return [portion(progress, k / count, (k + 1) / count) for k in range(count)]


def rising(progress: Progress | None) -> Progress:
    """Return progress that never falls, whatever it is given.

    >>> heard = rising(print)
    >>> heard(0.2), heard(0.1)
    0.2
    0.2
    (None, None)
    """
    highest = 0.0

    def heard(part: float) -> None:
        nonlocal highest
        highest = max(highest, part)
        if progress is not None:
            progress(highest)

    return heard


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

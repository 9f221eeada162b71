"""A call that may take minutes, or never come back: in a process of its own, with a limit."""

from __future__ import annotations

from collections.abc import Callable
from multiprocessing import get_context
from time import perf_counter


def limited(seconds: float, call: Callable[..., object], *arguments: object) -> tuple[object, float]:
    """Return what the call returns and its own seconds; None where it fails, and where it takes over the limit."""
    here, there = get_context("fork").Pipe(duplex=False)
    process = get_context("fork").Process(target=_answer, args=(there, call, arguments))
    process.start()
    there.close()
    try:
        return here.recv() if here.poll(seconds) else (None, float(seconds))
    except EOFError:  # it died
        return None, float("nan")
    finally:
        process.kill()
        process.join()


def _answer(pipe, call, arguments):
    start = perf_counter()
    try:
        found = call(*arguments)
    except Exception:  # whatever a peer raises: it made no curve
        found = None
    pipe.send((found, perf_counter() - start))

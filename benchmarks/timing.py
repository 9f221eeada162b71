"""Timing that a busy machine does not tilt: calls in turn, medians of repeats."""

import gc
from collections.abc import Callable, Sequence
from statistics import median
from time import perf_counter


def interleaved(calls: Sequence[Callable[[], object]], repeats: int, number: int = 1) -> list[float]:
    """Return each call's seconds: the median over the repeats (one more to warm up) of the mean of `number` calls."""
    times: list[list[float]] = [[] for _ in calls]
    for _ in range(repeats + 1):
        for call, taken in zip(calls, times, strict=True):
            gc.collect()  # what an earlier call left behind is not this one's to clear
            start = perf_counter()
            for _ in range(number):
                call()
            taken.append((perf_counter() - start) / number)
    return [median(taken[1:]) for taken in times]

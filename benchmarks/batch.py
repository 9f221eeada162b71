"""Throughput of `fit_many`: the corpus within 1e-3 of each curve's size, in 1 process (this one) and in 2.

python benchmarks/batch.py [--every 9] [--effort best]

Seconds by the clock, and of processor time with all processes: where other work keeps the processors busy the clock
tells little, and a ratio of processor times near 1 says what processes cost.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from time import perf_counter

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

import cadfit

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

SHARE = 1e-3


def selected(every):
    """Points by name, closed curves with their first point at the end, too; and the tolerances."""
    from corpus_data import curves  # not above: worker processes read this file, too, and need no pytest

    shapes = [(param.id, param.values[0]) for param in curves(1_000, None)][::every]
    points = {name: np.append(s.points, s.points[:1], axis=0) if s.closed else s.points for name, s in shapes}
    return points, [SHARE * shape.size for _, shape in shapes]


def used():
    """Seconds of processor time of this process and of those that it has waited for."""
    return sum(os.times()[:4])


def table(every=1, effort="fast"):
    from corpus_data import ABSENT, PRESENT

    if not PRESENT:
        return ABSENT
    points, tolerances = selected(every)
    lines = [
        f"| processes; {len(points)} curves | time | curves a second | times as many | processor time | poles |",
        "| --- | ---: | ---: | ---: | ---: | ---: |",
    ]
    first = None
    for jobs in (1, 2):
        start, busy = perf_counter(), used()
        batch = cadfit.fit_many(points, tolerances, jobs=jobs, effort=effort)
        seconds, busy = perf_counter() - start, used() - busy
        assert not batch.failures, batch.failures
        first = first or seconds
        poles = sum(fit.poles for fit in batch.fits)
        rate = len(points) / seconds
        lines.append(f"| {jobs} | {seconds:.1f} s | {rate:.1f} | {first / seconds:.2f} | {busy:.1f} s | {poles} |")
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--every", type=int, default=1, help="of the curves, take each such one")
    parser.add_argument("--effort", default="fast")
    options = parser.parse_args()
    print(table(options.every, options.effort))

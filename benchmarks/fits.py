"""How long a fit takes: `cadfit.fit` "fast" against one call of scipy's `splprep`, "best" against "fast", and memory.

`splprep` gets the smoothing that a tolerance suggests, s = n (tolerance / 2)^2, and does not keep the tolerance: it is
the yardstick, not a rival. Calls in turn, in one run; ratios of medians. Corpus: two curves of a kind of at most 1,000
points, at 1e-3 and 1e-4 of their size. Synthetic: an open space curve, and the same with noise of an eighth of the
tolerance.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from rich.progress import track

import cadfit

from memory import memory, synthetic
from peers import splprep_once
from timing import interleaved

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from corpus_data import ABSENT, PRESENT, curves

SIZES = (1_000, 10_000, 100_000, 1_000_000)
SHARES = (1e-3, 1e-4)  # of a curve's size
REPEATS = 3


def ratios(shape, share):
    """The seconds of "fast", "best" and `splprep` for one curve."""
    points, closed, tolerance = shape.points, shape.closed, share * shape.size
    calls = [
        lambda: cadfit.fit(points, tolerance, closed=closed, effort="fast"),
        lambda: cadfit.fit(points, tolerance, closed=closed, effort="best"),
        lambda: splprep_once(points, tolerance, closed),
    ]
    return interleaved(calls, REPEATS)


def real(per_kind=2):
    """The table for curves of the corpus."""
    if not PRESENT:
        return ABSENT
    rows = [
        "| corpus, tolerance | curves | fast / splprep: quartiles | median | best / fast: quartiles | median |",
        "| --- | ---: | ---: | ---: | ---: | ---: |",
    ]
    shapes = [p.values[0] for p in curves(per_kind, 1000)]
    for share in SHARES:
        taken = np.array([ratios(shape, share) for shape in track(shapes, f"fits at {share:g}", disable=None)])
        fast, best, splprep = taken.T
        cells = [f"{_quartiles(a / b)} | {np.median(a / b):.2f}" for a, b in ((fast, splprep), (best, fast))]
        rows.append(f"| {share:g} of the size | {len(shapes)} | " + " | ".join(cells) + " |")
    return "\n".join(rows)


def _quartiles(values):
    low, high = np.quantile(values, [0.25, 0.75])
    return f"{low:.2f} to {high:.2f}"


def grown(sizes=SIZES):
    """The table for synthetic curves of more and more points."""
    rows = [
        "| synthetic, points | poles | fast | splprep | fast / splprep | growth | memory |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    for noise, tolerance in ((0.0, 1e-3), (1.25e-3, 1e-2)):
        before = None
        for n in sizes:
            points = synthetic(n, noise)
            calls = [
                lambda points=points, tolerance=tolerance: cadfit.fit(points, tolerance, effort="fast"),
                lambda points=points, tolerance=tolerance: splprep_once(points, tolerance, False),
            ]
            fast, splprep = interleaved(calls, REPEATS if n <= 10_000 else 1)
            poles, taken = memory(n, noise, tolerance)
            growth = "" if before is None else f"{fast / before:.1f}"
            rows.append(
                f"| {'noisy' if noise else 'smooth'}, {n:,} | {poles} | {fast:.3g} s | {splprep:.3g} s "
                f"| {fast / splprep:.2f} | {growth} | {taken / 2**20:.0f} MB |"
            )
            before = fast
    return "\n".join(rows)


def table() -> str:
    return real() + "\n\n" + grown()


if __name__ == "__main__":
    print(table())

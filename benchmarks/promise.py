"""Whether every fit keeps its promise: the corpus at 1e-3, 1e-4 and 1e-5 of each curve's size, judged by samples.

python benchmarks/promise.py [--effort best] [--jobs 2] [--per-kind 3] [--kind airfoil]

`judge.violations` says what is not kept, by brute force; fits over two minutes are given up and counted as hangs. A
tolerance that float64 cannot hold at the curve's coordinates has to be refused.
"""

from __future__ import annotations

import argparse
import os
import signal
import sys
from collections import defaultdict
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from rich.progress import track

import cadfit

from judge import violations

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from corpus_data import ABSENT, PRESENT, curves

TOLERANCES = (1e-3, 1e-4, 1e-5)  # of a curve's size
LIMIT = 120  # seconds
OUTCOMES = ("fits", "refusals", "violations", "exceptions", "hangs")


class Outcome(NamedTuple):
    """What became of a fit: one of `OUTCOMES`, what was wrong, the seconds and poles it took."""

    kind: str
    name: str
    share: float
    what: str
    wrong: str
    seconds: float
    poles: int


class Hang(Exception):
    """A fit takes over the limit."""


def selected(per_kind, kind=None):
    """The curves: [(kind, name, points and whether they close)]."""
    families = [kind] if kind else None
    found = [(p.id, p.values[0]) for p in curves(per_kind, None, families)] if PRESENT else []
    return [(*name.split("-", 1), shape) for name, shape in found]


def outcome(kind, name, shape, share, effort):
    """One fit, judged."""
    tolerance, start, poles = share * shape.size, perf_counter(), 0
    signal.signal(signal.SIGALRM, _give_up)
    signal.setitimer(signal.ITIMER_REAL, LIMIT)
    try:
        fit = cadfit.fit(shape.points, tolerance, closed=shape.closed, effort=effort)
        seconds, poles = perf_counter() - start, fit.poles - len(fit.curves) + 1
        signal.setitimer(signal.ITIMER_REAL, 0)
        found = violations(fit, shape.points, shape.closed)
        what, wrong = ("violations", "; ".join(found)) if found else ("fits", "")
    except Hang:
        seconds, what, wrong = perf_counter() - start, "hangs", f"over {LIMIT} s"
    except Exception as error:
        seconds, what, wrong = perf_counter() - start, "exceptions", f"{type(error).__name__}: {error}"
        least = 256 * np.finfo(float).eps * shape.reach
        if isinstance(error, ValueError) and tolerance < least and "the tolerance must be at least" in wrong:
            what = "refusals"
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
    return Outcome(kind, name, share, what, wrong, seconds, poles)


def _give_up(_signal, _frame):
    raise Hang


def outcomes(shapes, effort, jobs):
    """The outcomes of all fits, the largest curves first."""
    tasks = [(*shape, share, effort) for shape in shapes for share in TOLERANCES]
    tasks.sort(key=lambda task: -len(task[2].points))
    with ProcessPoolExecutor(jobs) as pool:
        waiting = as_completed([pool.submit(outcome, *task) for task in tasks])
        return [future.result() for future in track(waiting, f"{effort}", len(tasks), disable=None)]


def report(found):
    """The table, and below it what was wrong."""
    rows = [
        "| curves | " + " | ".join(OUTCOMES) + " | median | slowest | which |",
        "| --- " + 7 * "| ---: " + "| --- |",
    ]
    groups = defaultdict(list)
    for one in found:
        groups[one.kind].append(one)
    for kind, some in [*sorted(groups.items()), ("all", found)]:
        slowest = max(some, key=lambda one: one.seconds)
        counts = [str(sum(one.what == what for one in some)) for what in OUTCOMES]
        middle = np.median([one.seconds for one in some])
        rows.append(
            f"| {kind} | " + " | ".join(counts) + f" | {middle:.2f} s | {slowest.seconds:.1f} s "
            f"| {slowest.name} at {slowest.share:g} |"
        )
    wrong = sorted(one for one in found if one.what not in ("fits", "refusals"))
    return "\n".join(
        rows + [""] + [f"{one.kind} {one.name} at {one.share:g}: {one.what}: {one.wrong}" for one in wrong]
    )


def table(effort="fast", jobs=2, per_kind=10_000, kind=None) -> str:
    shapes = selected(per_kind, kind)
    return report(outcomes(shapes, effort, jobs)) if shapes else ABSENT


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--effort", choices=("fast", "best"), default="fast")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--per-kind", type=int, default=10_000)
    parser.add_argument("--kind")
    given = parser.parse_args()
    print(table(given.effort, given.jobs, given.per_kind, given.kind))

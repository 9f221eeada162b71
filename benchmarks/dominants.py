"""Dominant points: the default's square error against the paper's search, the optimum, and other ways to thin a curve.

Real curves of a corpus ($CADFIT_CORPUS, or ../shared/corpus beside the repository), eight of a kind, of at most 2,000
points. First table: at four parts of the points, the default's square error over that of the paper's search (geometric
mean and largest), the time (of all curves together, and the median), and the error over the optimum's for open curves
of at most 60 points. Second: curves of k dominant points have 3k - 2 poles, and so have DOM's; of every curve the sum
of the squared distances of all points to the curve and the largest deviation, over those of the paper's C2 curve
through the dominant points of its search. Third: the time for many points, and that of the literal search at 2,000.
"""

from __future__ import annotations

import sys
from collections import defaultdict
from pathlib import Path
from time import perf_counter, process_time

import numpy as np
from rich.progress import track

import cadfit
from cadfit.fitting.dom import dom
from cadfit.fitting.dominant import initial_dominant_points, square_error, turn_angles
from cadfit.fitting.dominant_optimum import optimal_dominant_points

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
import reference
from corpus_data import ABSENT, PRESENT, curves

PARTS = (0.9, 0.8, 0.7, 0.6)
FEW = (0.3, 0.2, 0.1, 0.05)  # at 3 poles a dominant point, DOM has no more poles than points below a third
METHODS = ("paper", "best")


def selected(per_family=8):
    return [p.values[0] for p in curves(per_family=per_family) if PRESENT]


def mean(ratios):
    return float(np.exp(np.mean(np.log(ratios))))


def rounding(points):
    return len(points) * (1e-15 * np.abs(points).max()) ** 2


def timed(points, **how):
    start = process_time()
    found = cadfit.dominant_points(points, **how)
    return found, process_time() - start


def against_paper(shapes) -> str:
    ratios, optima, times = defaultdict(list), defaultdict(list), defaultdict(list)
    for shape in track(shapes, "paper, best, optimum", disable=None):
        points, least = shape.points, rounding(shape.points)
        for part in PARTS:
            count = max(3, int(part * len(points) + 0.5))
            (paper, slow), (best, quick) = (timed(points, count=count, closed=shape.closed, method=m) for m in METHODS)
            ratios[part].append((best.square_error + least) / (paper.square_error + least))
            times[part].append((slow, quick))
            if len(points) <= 60 and not shape.closed:
                optimum = square_error(points, optimal_dominant_points(points, count))
                optima[part].append((best.square_error + least) / (optimum + least))
    rows = [
        "| part | error | largest | time | median | over the optimum, largest | curves |",
        "| --- " + 6 * "| ---: " + "|",
    ]
    for part in PARTS:
        slow, quick = np.transpose(times[part])
        rows.append(
            f"| {part:.0%} | {mean(ratios[part]):.4f} | {max(ratios[part]):.3f} | {quick.sum() / slow.sum():.2f} "
            f"| {np.median(quick / slow):.2f} | {max(optima[part]):.3f} | {len(ratios[part])}, {len(optima[part])} |"
        )
    return "\n".join(rows)


def distances(spline, points):
    """The sum of the squared distances to the curve, and the certified largest deviation at the points."""
    far = cadfit.deviation(spline, points)
    return len(points) * far.rms**2, far.points


def douglas_peucker(points, count):
    """The ends, and the point farthest from the chord of its segment, again and again."""
    from heapq import heappop, heappush

    from cadfit.bezier import distance_to_segment

    rows, queue = [0, len(points) - 1], []

    def push(a, b):
        if b - a > 1:
            far = distance_to_segment(points[a + 1 : b], points[a], points[b])
            heappush(queue, (-far.max(), a, a + 1 + int(far.argmax()), b))

    push(*rows)
    while len(rows) < count:
        _, a, k, b = heappop(queue)
        rows.append(k)
        push(a, k)
        push(k, b)
    return np.sort(rows)


def ways(points, count):
    paper, best = (cadfit.dominant_points(points, count, method=m).indices for m in METHODS)
    return {
        "paper": cadfit.cardinal_spline(points[paper]),
        "ours": cadfit.cardinal_spline(points[best], curvature=1.0),
        "Douglas-Peucker": cadfit.cardinal_spline(points[douglas_peucker(points, count)]),
        "DOM": dom(points, 3 * count - 2),
    }


def against_dom(shapes) -> str:
    found = defaultdict(list)
    for shape in track(shapes, "DOM, Douglas-Peucker", disable=None):
        points = np.vstack([shape.points, shape.points[:1]]) if shape.closed else shape.points
        if not 40 <= len(points) <= 600:
            continue
        for part in FEW:
            if round(part * len(points)) < 4:
                continue
            made = {name: distances(curve, points) for name, curve in ways(points, round(part * len(points))).items()}
            for name, figures in made.items():
                found[name, part].append(np.array(figures) / np.array(made["paper"]))
    rows = [
        "| points | " + " | ".join(["ours", "Douglas-Peucker", "DOM"]) + " | curves |",
        "| --- " + 4 * "| ---: " + "|",
    ]
    for part in FEW:
        cells = []
        for name in ("ours", "Douglas-Peucker", "DOM"):
            squares, largest = (mean(np.maximum(each, 1e-12)) for each in np.transpose(found[name, part]))
            cells.append(f"{squares:.3g}, {largest:.3g}")
        rows.append(f"| {part:.0%} | " + " | ".join(cells) + f" | {len(found['DOM', part])} |")
    return "\n".join(rows)


def scribble(n):
    """A path of even density with a little noise."""
    t = np.arange(n) / 50.0
    path = np.column_stack([t + np.sin(1.3 * t) + 0.3 * np.sin(3.7 * t), 2.0 * np.cos(t) + 0.3 * np.sin(5.0 * t)])
    return path + np.random.default_rng(1).normal(size=(n, 2)) * 1e-3


def speed() -> str:
    rows = ["| points | paper, 70 % | a swap | best, 70 % |", "| ---: " + 3 * "| ---: " + "|"]
    for n in (1_000, 10_000, 100_000):
        (paper, slow), (_, quick) = (timed(scribble(n), fraction=0.7, method=m) for m in METHODS)
        swaps = len(paper.history) - 1
        rows.append(f"| {n:,} | {slow:.2f} s, {swaps} swaps | {slow / max(swaps, 1) * 1e3:.2f} ms | {quick:.2f} s |")
    points = scribble(2_000)
    _, ours = timed(points, fraction=0.7, method="paper")
    start, begun = initial_dominant_points(points, 1_400).tolist(), perf_counter()
    reference.refined_dominant_points(points, turn_angles(points).tolist(), start, False)
    taken = perf_counter() - begun
    return "\n".join(rows) + f"\n\nThe literal search at 2,000 points: {taken:.1f} s, {taken / ours:.0f} times ours."


def table() -> str:
    shapes = selected()
    if not shapes:
        return ABSENT
    return "\n\n".join([against_paper(shapes), against_dom(shapes), speed()])


if __name__ == "__main__":
    print(table())

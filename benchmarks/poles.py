"""How many poles a tolerance takes: `cadfit.fit` against the better of OCCT's and FITPACK's curves, by kind of curve.

Real curves of a corpus ($CADFIT_CORPUS, or ../shared/corpus beside the repository), eight of a kind, of at most 2,000
points; closed ones closed. A peer counts where its largest distance from a point is within the tolerance; how many of
those keep to the rule between points, as ours always do, is in the last column. Geometric means of (our poles / the
better peer's).
"""

from __future__ import annotations

import sys
from collections import defaultdict
from pathlib import Path

import numpy as np
from rich.progress import track

import cadfit

from peers import fitpack, judged, occt

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from corpus_data import ABSENT, PRESENT, curves

TOLERANCES = (1e-3, 1e-4)  # of a curve's size


def selected():
    """The curves: {(kind, number): points and whether they close}."""
    return {(p.id.split("-")[0], k): p.values[0] for k, p in enumerate(curves(per_family=8)) if PRESENT}


def others(shapes):
    """The better of those peers that keep the tolerance at the points: {(kind, number, tolerance): Peer or None}."""
    found = {}
    for (kind, k), shape in track(shapes.items(), "OCCT and FITPACK", disable=None):
        for share in TOLERANCES:
            tolerance = share * shape.size
            made = [make(shape.points, tolerance, shape.closed) for make in (occt, fitpack)]
            judgements = [judged(curve, shape.points, tolerance, shape.closed) for curve in made if curve is not None]
            found[kind, k, share] = min((peer for peer in judgements if peer.points <= tolerance), default=None)
    return found


def ours(shapes, effort):
    """Our numbers of poles: {(kind, number, tolerance): poles}; curves that meet at a corner share a pole there."""
    found = {}
    for (kind, k), shape in track(shapes.items(), f"cadfit, {effort}", disable=None):
        for share in TOLERANCES:
            fit = cadfit.fit(shape.points, share * shape.size, closed=shape.closed, effort=effort)
            found[kind, k, share] = fit.poles - len(fit.curves) + 1
    return found


def table() -> str:
    shapes = selected()
    if not shapes:
        return ABSENT
    peers, poles = others(shapes), {effort: ours(shapes, effort) for effort in ("fast", "best")}
    ratios, kept = defaultdict(list), defaultdict(list)
    for (kind, k, share), peer in peers.items():
        if peer is None:
            continue
        for row in (kind, "all"):
            kept[row, share].append(peer.kept)
            for effort in poles:
                ratios[row, effort, share].append(poles[effort][kind, k, share] / peer.poles)
    rows = [
        "| curves | fast, 1e-3 | best, 1e-3 | peers that keep the rule | fast, 1e-4 | best, 1e-4 | that keep it |",
        "| --- " + 6 * "| ---: " + "|",
    ]
    for row in [*dict.fromkeys(kind for kind, _ in shapes), "all"]:
        cells = []
        for share in TOLERANCES:
            cells += [mean(ratios[row, effort, share]) for effort in poles]
            cells.append(f"{sum(kept[row, share])} of {len(kept[row, share])}")
        rows.append(f"| {row} | " + " | ".join(cells) + " |")
    return "\n".join(rows)


def mean(ratios):
    """The geometric mean."""
    return f"{np.exp(np.mean(np.log(ratios))):.3f}" if ratios else "–"


if __name__ == "__main__":
    print(table())

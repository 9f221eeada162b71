"""A word engraved: a program of short lines before, of arcs after, and how fast a machine could go through its joints.

The outlines of DejaVu Sans, 20 mm high, cut into chords 0.005 mm off at most (data/engraved.nc), are refitted within
0.02 mm. Writes out/toolpath.png and out/engraved.nc (or into the folder given).
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from cadfit.toolpaths import moves, refit

DATA = Path(__file__).parent / "data"
TOLERANCE = 0.02
BEFORE, AFTER = "#0072b2", "#d55e00"
ACCELERATION, JOLT = 500.0, 1.0  # mm/s^2 to the side; mm/s that the velocity may change by at once


def cuts(path):
    """The cutting moves at depth of a program, those of each outline together."""
    outlines = [[]]
    for move in moves(path):
        if move.motion and move.end[2] < 0.0 and move.start[2] == move.end[2]:
            outlines[-1].append(move)
        elif outlines[-1]:
            outlines.append([])
    return [outline for outline in outlines if outline]


def sampled(outline, step=0.01):
    """Places (n, 2) along moves, the direction, the curvature and the length there."""
    places, angles, bends = [], [], []
    for move in outline:
        n = max(2, int(move.length / step))
        t = (np.arange(n) + 0.5) / n
        start, end = np.array(move.start[:2]), np.array(move.end[:2])
        if move.arc is None:
            places.append(start + t[:, None] * (end - start))
            angles.append(np.full(n, np.arctan2(*(end - start)[::-1])))
            bends.append(np.zeros(n))
        else:
            centre = np.array(move.arc.centre)
            turned = np.arctan2(*(start - centre)[::-1]) + t * move.arc.sweep
            places.append(centre + move.arc.radius * np.column_stack([np.cos(turned), np.sin(turned)]))
            angles.append(turned + np.copysign(np.pi / 2, move.arc.sweep))
            bends.append(np.full(n, np.sign(move.arc.sweep) / move.arc.radius))
    return np.concatenate(places), np.concatenate(angles), np.concatenate(bends)


def joints(outline):
    """The angle by which the path turns from each move to the next (radians), and the speed that its joint allows."""
    ends = []
    for move in outline:
        _, angles, _ = sampled([move], move.length / 2)
        half = move.arc.sweep / 4 if move.arc else 0.0  # from the middles of the halves to the ends
        ends.append((angles[0] - half, angles[-1] + half))
    turn = np.array([b[0] - a[1] for a, b in zip(ends[:-1], ends[1:], strict=True)])
    turn = np.abs((turn + np.pi) % (2 * np.pi) - np.pi)
    return turn, JOLT / (2.0 * np.maximum(np.sin(turn / 2.0), 1e-9))


def gaps(places, outline):
    """How far places are from the path of moves, positive to its left."""
    fine, angles, _ = sampled(outline, 0.002)
    near = np.array([np.argmin(((fine - place) ** 2).sum(axis=1)) for place in places])
    gap = places - fine[near]
    return gap[:, 1] * np.cos(angles[near]) - gap[:, 0] * np.sin(angles[near])


def main(folder):
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    source, target = DATA / "engraved.nc", folder / "engraved.nc"
    done = refit(source, target, TOLERANCE, effort="best")
    before, after = cuts(source), cuts(target)
    figure, axes = plt.subplot_mosaic(
        [["path", "path"], ["gap", "speed"], ["bend", "speed"]], figsize=(10.0, 8.0), height_ratios=[1.5, 1, 1],
        layout="constrained",
    )  # fmt: skip
    for outlines, colour, size, name in ((before, BEFORE, 2.0, "before"), (after, AFTER, 4.5, "after")):
        count = sum(map(len, outlines))
        for k, outline in enumerate(outlines):
            label = f"{name}: {count} moves" if not k else None
            ends = np.array([outline[0].start[:2], *(move.end[:2] for move in outline)])
            axes["path"].plot(*ends.T, "o", color=colour, ms=size, label=label)
            axes["path"].plot(*sampled(outline)[0].T, color=colour, lw=0.8)
    axes["path"].set(aspect="equal", title=f"The path and the ends of its moves (mm), within {TOLERANCE} mm")
    axes["path"].legend(loc="upper left")
    old, new = before[0], after[0]
    places, _, bends = sampled(new, 0.02)
    along = np.linspace(0.0, sum(move.length for move in new), len(places))
    axes["gap"].plot(along, 1e3 * gaps(places, old), color=AFTER, lw=1)
    for side in (-1, 1):
        axes["gap"].axhline(side * 1e3 * TOLERANCE, color="#888", lw=0.8, ls="--")
    axes["gap"].set(title="First outline: off the old path (micrometres)", xlabel="along it (mm)")
    axes["bend"].plot(along, bends, color=AFTER, lw=1)
    axes["bend"].set(title="Its curvature (1/mm): steps, but no kinks", xlabel="along it (mm)")
    found = {"moves": tuple(done.moves), "deviation": done.deviation, "arcs": done.arcs}
    for outline, colour, name in ((old, BEFORE, "before"), (new, AFTER, "after")):
        turn, speed = joints(outline)
        ends = np.cumsum([move.length for move in outline])[:-1]
        radii = np.array([np.sqrt(ACCELERATION * m.arc.radius) if m.arc else np.inf for m in outline])
        held = np.minimum(speed, np.minimum(radii[:-1], radii[1:]))
        axes["speed"].semilogy(ends, np.minimum(held, 1e3), "o-", color=colour, ms=2.5, lw=0.8, label=name)
        smooth = turn < np.radians(35.0)
        found[f"kink {name}"] = float(np.degrees(turn[smooth].max()))
        found[f"speed {name}"] = float(np.median(held[smooth]))
    axes["speed"].set(
        title=f"Speed through its joints (mm/s):\nno jolt over {JOLT:g} mm/s, {ACCELERATION:g} mm/s² to the side",
        xlabel="along it (mm)",
    )
    axes["speed"].legend()
    figure.savefig(folder / "toolpath.png", dpi=100)
    plt.close(figure)
    print("  ".join(f"{key} {value}" for key, value in found.items()))
    return found


if __name__ == "__main__":
    main(*sys.argv[1:] or ["out"])

"""docs/pictures/poles.png: how many poles a tolerance takes, cadfit against OCCT and FITPACK, six curves.

python benchmarks/chart.py [file]. Peers' curves that miss the tolerance at the points are drawn hollow; what takes
over a minute, or fails, is left out.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import matplotlib
import numpy as np
from rich.progress import track

import cadfit

from limited import limited
from literature import named
from peers import fitpack, judged, occt

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from corpus_data import ABSENT, PRESENT

PICTURE = Path(__file__).resolve().parents[1] / "docs" / "pictures" / "poles.png"
SHARES = np.geomspace(1e-2, 1e-5, 7)  # of a curve's size
LIMIT = 60.0  # seconds
CURVES = {  # kind: name, title
    "turbine_section": ("IEA-15-240-RWT_AF15_Coords", "turbine section"),
    "font_outline": ("DejaVuSans/U+0053.0", "font outline"),
    "handwriting": ("bg1/Balinese/character12/0119_02", "pen stroke"),
    "wheel_rail": ("Car7216_0001r.whl", "scanned wheel"),
    "gps_track": ("korita-zbevnica.0", "GPS track"),
    "tract": ("tracks300/126", "nerve tract in 3D"),
}
STYLES = {  # colours that colour-blind people tell apart (Okabe and Ito, 2002), and markers for everyone
    "cadfit best": ("#0072b2", "o"),
    "cadfit fast": ("#56b4e9", "s"),
    "FITPACK": ("#d55e00", "^"),
    "OCCT": ("#000000", "D"),
}


def selected(kinds):
    """The curves: {title: points and whether they close}."""
    found = {}
    for kind in kinds:
        name, title = CURVES[kind]
        shape = named(kind, name)
        found[f"{title}, {len(shape.points)} points"] = shape
    return found


def poles_at(shape, share):
    """The poles at one tolerance, and whether they keep it at the points: {who: (poles, kept)}."""
    tolerance, found = share * shape.size, {}
    for effort in ("fast", "best"):
        fit = cadfit.fit(shape.points, tolerance, closed=shape.closed, effort=effort)
        found[f"cadfit {effort}"] = fit.poles - len(fit.curves) + 1, True
    for who, make in (("OCCT", occt), ("FITPACK", fitpack)):
        curve, _ = limited(LIMIT, make, shape.points, tolerance, shape.closed)
        if curve is not None:
            far = judged(curve, shape.points, tolerance, shape.closed)
            found[who] = far.poles, far.points <= tolerance
    return found


def measured(kinds=tuple(CURVES)):
    """Everything the chart shows: {title: [{who: (poles, kept)} for each tolerance]}."""
    shapes = selected(kinds)
    tasks = [(title, shape, share) for title, shape in shapes.items() for share in SHARES]
    found = {title: [] for title in shapes}
    for title, shape, share in track(tasks, "chart", disable=None):
        found[title].append(poles_at(shape, share))
    return found


def table(path=PICTURE) -> str:
    """The chart's numbers, drawn into a file on the way; in brackets those of curves that miss the tolerance."""
    if not PRESENT:
        return ABSENT
    found = measured()
    draw(found, path)
    rows = ["| curve | who | " + " | ".join(f"{share:.2g}" for share in SHARES) + " |"]
    rows.append("| --- | --- " + len(SHARES) * "| ---: " + "|")
    for title, steps in found.items():
        for who in STYLES:
            pairs = [step.get(who, ("–", True)) for step in steps]  # no curve, or not in time
            cells = [f"{poles}" if kept else f"({poles})" for poles, kept in pairs]
            rows.append(f"| {title} | {who} | " + " | ".join(cells) + " |")
    return "\n".join(rows)


def draw(found, path):
    """Draw the small multiples into a file."""
    matplotlib.use("Agg")
    from matplotlib import pyplot as plt
    from matplotlib.ticker import FixedLocator, NullFormatter, StrMethodFormatter

    figure, axes = plt.subplots(2, 3, figsize=(11, 6.6), sharex=True, layout="constrained")
    for ax, (title, steps) in zip(axes.flat, found.items(), strict=False):
        for who, (colour, marker) in STYLES.items():
            shown = [(share, *step[who]) for share, step in zip(SHARES, steps, strict=True) if who in step]
            if not shown:
                continue
            x, y, kept = map(np.array, zip(*shown, strict=True))
            first = who == "cadfit best"
            order = 5 if first else 4
            ax.plot(x, y, color=colour, lw=2.2 if first else 1.3, zorder=order - 2)
            for inside, face in ((kept, colour), (~kept, "white")):
                ax.plot(x[inside], y[inside], marker, ms=6, color=colour, mfc=face, mew=1.4, zorder=order)
        ax.set(xscale="log", yscale="log", title=title)
        ax.title.set_size(10.5)
        low, high = ax.get_ylim()
        ticks = [t * 10**k for k in range(5) for t in (1, 2, 5) if low <= t * 10**k <= high]
        ax.yaxis.set_major_locator(FixedLocator(ticks))
        ax.yaxis.set_major_formatter(StrMethodFormatter("{x:,.0f}"))
        ax.yaxis.set_minor_formatter(NullFormatter())
        ax.grid(color="#dddddd", lw=0.6)
        ax.spines[["top", "right"]].set_visible(False)
    axes[0, 0].invert_xaxis()
    figure.supxlabel("tolerance, in parts of the curve's size", fontsize=10.5)
    figure.supylabel("poles", fontsize=10.5)
    handles = [plt.Line2D([], [], color=c, marker=m, label=who, lw=1.8) for who, (c, m) in STYLES.items()]
    handles.append(plt.Line2D([], [], color="#777777", marker="o", mfc="white", lw=0, label="misses the tolerance"))
    figure.legend(handles=handles, loc="outside upper center", ncols=5, frameon=False)
    figure.savefig(path, dpi=130)
    plt.close(figure)


if __name__ == "__main__":
    print(table(*sys.argv[1:2]))

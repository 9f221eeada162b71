"""A rib of a wing as a drawing of chords: splines and true arcs after, with the names of its contours.

The polylines of data/rib.svg are fitted within 0.05 mm, its circle and its smooth path are taken over; the same as
lines and arcs. Writes drawing.png, rib.dxf (SPLINE entities) and rib_arcs.dxf (polylines with bulges) into out (or
the folder given), and reads both back.
"""

import sys
from pathlib import Path

import ezdxf
import matplotlib.pyplot as plt
import numpy as np

import cadfit
from cadfit.cli import main as run

SOURCE = Path(__file__).parent / "data" / "rib.svg"
TOLERANCE = 0.05
VERMILION, GREY = "#d55e00", "#888888"


def draw(chords, splines, drawn):
    """Draw the rib whole, and its nose: the chords, the fit's poles, and the ends of its arcs."""
    figure, (whole, nose) = plt.subplots(2, 1, figsize=(10.0, 7.0), height_ratios=[1, 2], layout="constrained")
    for axes, size in ((whole, 2.5), (nose, 5.0)):
        for k, (before, after, arcs) in enumerate(zip(chords.curves, splines.curves, drawn, strict=True)):
            first = k == 0
            vertices = before(before.distinct_knots)
            axes.plot(*vertices.T, ".", color=GREY, ms=size, label="vertices of the drawing" if first else None)
            after.plot(axes, poles=False, comb=False).lines[-1].set(label="splines" if first else "_", linewidth=1.2)
            ends = np.array([(x, y) for x, y, *_ in arcs.get_points("xyb")])
            axes.plot(*ends.T, "o", color=VERMILION, ms=size, label="ends of lines and arcs" if first else None)
        axes.set(aspect="equal")
    whole.set_title(f"A rib (mm), within {TOLERANCE} mm")
    nose.set(xlim=(-1.0, 24.0), ylim=(-6.0, 8.0), title="Its nose")
    nose.legend(loc="lower right")
    return figure


def main(folder):
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    splines, arcs = folder / "rib.dxf", folder / "rib_arcs.dxf"
    for target, *options in ((splines,), (arcs, "--arcs")):
        if run(["fit", str(SOURCE), "-t", str(TOLERANCE), *options, "-o", str(target)]):
            raise SystemExit(f"{target} was not written")
    chords, back = cadfit.read(SOURCE), cadfit.read(splines)
    drawn = list(ezdxf.readfile(arcs).modelspace())
    figure = draw(chords, back, drawn)
    figure.savefig(folder / "drawing.png", dpi=110)
    plt.close(figure)
    fitted = chords.names.index("outline")
    contour = chords.curves[fitted]
    away = cadfit.deviation(back.curves[fitted], contour(contour.distinct_knots), True)
    counts = len(contour.distinct_knots), len(back.curves[fitted].poles), len(drawn[fitted])
    print("the outline: {} vertices, {} poles, {} lines and arcs".format(*counts))
    return {
        "names": (chords.names, back.names, tuple(each.dxf.layer for each in drawn)),
        "deviation": max(away.points, away.between),
        "counts": counts,
    }


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "out")

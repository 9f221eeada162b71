"""CadQuery's experimental `occ_impl.nurbs`: a curve of as many poles as asked for, in CadQuery's own environment.

python nurbs.py: reads an .npz (points (n, d), whether closed, poles) from its input, writes one with the curve's poles
and knots, and the seconds of a second call (the first compiles), to its output. Uniform knots, chord-length parameters.
"""

from __future__ import annotations

import subprocess
import sys
from io import BytesIO
from pathlib import Path
from time import perf_counter

import numpy as np

PYTHON = Path(__file__).resolve().parents[1] / ".venv-cadquery" / "bin" / "python"


def approximate(points, closed, poles):
    """The curve of so many poles (closed: counted as a clamped curve's) and its seconds; None where there is none."""
    import cadfit

    if not PYTHON.is_file():
        return None, float("nan")
    given, start = BytesIO(), perf_counter()
    np.savez(given, points=points, closed=closed, poles=poles)
    done = subprocess.run([PYTHON, __file__], input=given.getvalue(), capture_output=True, check=False)
    if done.returncode:
        return None, perf_counter() - start
    with np.load(BytesIO(done.stdout)) as found:
        if not np.isfinite(found["poles"]).all():  # its normal equations can be singular
            return None, float(found["seconds"])
        if closed:
            return cadfit.periodic(np.roll(found["poles"], -1, axis=0), found["knots"]), float(found["seconds"])
        return cadfit.BSpline(found["poles"], found["knots"]), float(found["seconds"])


def main():
    """Answer one request."""
    from cadquery.occ_impl import nurbs

    with np.load(BytesIO(sys.stdin.buffer.read())) as given:
        points, closed, poles = given["points"], bool(given["closed"]), int(given["poles"])
    around = np.vstack([points, points[:1]]) if closed else points
    u = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(around, axis=0), axis=1))])
    u = u[: len(points)] / u[-1]
    make = nurbs.periodicApproximate if closed else nurbs.approximate
    for _ in range(2):
        start = perf_counter()
        curve = make(points, us=u, knots=poles - 2)  # so many distinct knots make that many poles
        seconds = perf_counter() - start
    answer = BytesIO()
    np.savez(answer, poles=curve.pts, knots=curve.knots, seconds=seconds)
    sys.stdout.buffer.write(answer.getvalue())


if __name__ == "__main__":
    main()

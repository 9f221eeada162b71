"""A fit, or several beside each other, as one HTML page that needs nothing else: to look at, to send, to keep."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from cadfit.fitting.result import Fit
from cadfit.replacing import replacing
from cadfit.report.data import Entry as Entry
from cadfit.report.page import page
from cadfit.stages import Progress, portion, stage


def report(
    fit: Fit, path: str | os.PathLike[str], *, title: str = "", unit: str = "", progress: Progress | None = None
) -> None:
    """Write a fit as one HTML file that opens in any browser, offline.

    A view of points, curve, poles, knots, curvature comb and corners, to zoom and, in 3D, to turn; the deviation and
    the curvature along the curve, linked with the view; the figures; the call that makes the fit again. `unit` is
    written where lengths are. A 1D fit is shown as a graph over the parameter; of more than three coordinates the view
    shows three at a time, and all figures are those in all of them. More than 20,000 points are thinned for the view,
    each stretch keeping its farthest, and the page says so. `progress` is called with the part that is done, from 0 to
    1; raising from it stops.

    Raises OSError naming `path` when it cannot be written; an old file stays whole until the new one is.

    >>> import cadfit, pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "wave.html"
    >>> cadfit.fit([[0, 0], [1, 0.1], [2, 0], [3, 0.1], [4, 0]], 0.15).report(path, title="Wave", unit="mm")
    >>> "<title>Wave</title>" in path.read_text(encoding="utf-8")
    True
    """
    call = [fit.call] if fit.call else []
    # Its name without the folders, which are no one else's.
    write(
        [Entry("fit", fit)], path, title or "Fit", unit, [*call, f"fit.report({Path(path).name!r})"], progress=progress
    )


def write(
    entries: Sequence[Entry],
    path: str | os.PathLike[str],
    title: str,
    unit: str = "",
    calls: Sequence[str] = (),
    source: Path | None = None,
    *,
    without: Sequence[str] = (),
    progress: Progress | None = None,
) -> None:
    """Write one page of one fit or several, with what made it: calls or commands, and the file the points are of.

    `without`: what is to be said of ways that made no curve.
    """
    with stage("writing the page"):
        text = page(entries, title, unit, calls, source, without, portion(progress, 0.0, 0.9))
        with replacing(Path(path)) as beside:
            beside.write_text(text, encoding="utf-8")
    portion(progress, 0.0, 1.0)(1.0)

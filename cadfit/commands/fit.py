"""`cadfit fit`."""

from __future__ import annotations

from pathlib import Path

import typer

from cadfit.commands.many import check_all, fit_all, placed
from cadfit.commands.options import (
    AsArcs,
    BetweenPoints,
    Closed,
    Corners,
    Curvature,
    Formats,
    Fraction,
    HowLong,
    HowTo,
    Ins,
    InUnit,
    Jobs,
    Outs,
    Page,
    Quiet,
    SquareError,
    Summary,
    Tension,
    Unit,
    Verbose,
    Within,
)
from cadfit.commands.terminal import Mistake, about, busy, check, check_page, check_places, report, timed, write_all


def fit(
    context: typer.Context,
    source: Ins,
    output: Outs = None,
    tolerance: Within = None,
    between: BetweenPoints = None,
    corners: Corners = None,
    effort: HowLong = None,
    arcs: AsArcs = False,
    method: HowTo = None,
    tension: Tension = None,
    curvature: Curvature = None,
    fraction: Fraction = None,
    square_error: SquareError = None,
    closed: Closed = None,
    unit: InUnit = Unit.mm,
    file_format: Formats = None,
    jobs: Jobs = None,
    summary: Summary = None,
    page: Page = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Fit B-splines to points, within a tolerance or through all, and write them to .step .stp .brep .json .csv.

    Of a drawing (.dxf .svg) every polyline is fitted, and all other contours are taken over, with their names.

    Several files are fitted at once into a folder: cadfit fit *.csv -o out/ -t 0.01; the exit status is 1 if some
    of them failed.
    """
    from cadfit.drawings import made, made_of_arcs, meant, named
    from cadfit.files import ArcContours, Curves, Kind, contents
    from cadfit.methods import How, write_report

    if not output and page is None:
        raise Mistake(f"{source[0]}: where to? --output says it, or --report for a page to look at")
    output = output or []
    how = How(method, closed, tension, curvature, tolerance, between, corners, effort, fraction, square_error)
    if len(source) > 1 and page is not None:
        raise Mistake(f"{page}: --report is for one file, not {len(source)}")
    if arcs and (len(source) > 1 or page is not None):
        raise Mistake(f"{source[0]}: --arcs is for one file, and goes without --report")
    targets = placed(source, output, file_format) if output else None
    if len(source) > 1:
        assert targets is not None
        how.check()
        check_all(source, targets, summary)
        return fit_all(source, targets, how, jobs=jobs, unit=unit, summary=summary, quiet=quiet, verbose=verbose)
    if summary is not None or jobs is not None:
        raise Mistake(f"{source[0]}: --jobs and --summary are for several files")
    [only] = source
    paths = [Path(each) for each in output] if targets is None else targets[0]
    with timed(verbose):
        kind: Kind = "arcs" if arcs else "curves"
        check(only, paths, kind)
        check_page(page, source)
        if targets is None:
            check_places(paths)
        else:
            check_all(source, targets, None)
        with busy(f"reading {only}", quiet) as progress, about(only):
            held = contents(only, unit.value, progress)
        single = held.vertices if isinstance(held, Curves) else None
        points = held if single is None else single
        if page is not None and isinstance(points, Curves):
            raise Mistake(f"{only}: --report is for points, and it holds {len(points.curves)} contours")
        how = meant(how, only, points)
        with busy(f"fitting {only}", quiet) as progress, about(only):
            result, said = (made_of_arcs if arcs else made)(points, how, progress)
        write_all(only, paths, kind, result.dimension, named(result, held), unit, quiet)
        if page is not None and not isinstance(result, ArcContours):
            with busy(f"writing {page}", quiet) as progress:
                write_report(page, only, points, result, how, unit.value, context.obj, progress)
        report(str(only), said, [*paths, *([page] if page else [])], quiet)
    return 0

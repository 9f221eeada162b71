"""`cadfit fit` of several files: one file each way, in worker processes, a summary at the end."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cadfit.commands.options import Unit
from cadfit.commands.terminal import Mistake, about, busy, say, say_times

if TYPE_CHECKING:
    from cadfit.methods import How

FORMAT = "step"  # of files in a folder, where none is named


def placed(sources: list[Path], outputs: list[str], formats: list[str] | None) -> list[list[Path]] | None:
    """Return the files to write for each source, where the outputs are folders; None where they are files.

    A folder is what is one, what ends with a slash, and for several sources what has no suffix. Files in it have the
    names of the sources and the suffixes of the formats.
    """
    if "" in outputs:
        raise Mistake("an output has no name: give a file, or a folder such as out/")
    if twice := [each for k, each in enumerate(outputs) if each in outputs[:k]]:
        raise Mistake(f"{twice[0]}: given twice as an output")
    folders = [Path(each) for each in outputs if _is_folder(each, len(sources) > 1)]
    if not folders:
        if len(sources) > 1:
            raise Mistake(f"{outputs[0]}: several files need a folder to go to, such as out/")
        if formats:
            raise Mistake(f"{outputs[0]}: --format is for files in a folder; the suffix says it here")
        return None
    if strangers := [each for each in outputs if Path(each) not in folders]:
        raise Mistake(f"{strangers[0]}: a file, where {folders[0]} is a folder: only one of both can be meant")
    suffixes = [f".{each.lstrip('.').lower()}" for each in formats or [FORMAT]]
    return [[folder / (source.stem + suffix) for folder in folders for suffix in suffixes] for source in sources]


def _is_folder(output: str, several: bool) -> bool:
    path = Path(output)
    return output.endswith(("/", "\\")) or path.is_dir() or (several and not path.suffix)


def check_all(sources: list[Path], targets: list[list[Path]], summary: Path | None) -> None:
    """Refuse two results of one name, results over sources, and what cannot hold curves; then make the folders."""
    from cadfit.files import check

    whose: dict[str, Path] = {}
    given = {path.resolve() for path in sources}
    for source, paths in zip(sources, targets, strict=True):
        for path in paths:
            other = whose.setdefault(str(path).casefold(), source)  # some disks hold A.step and a.step for the same
            if other is not source:
                if source == other:
                    raise Mistake(f"{source}: given twice")
                raise Mistake(f"{source} and {other} would both be written to {path}")
            if path.resolve() in given:
                raise Mistake(f"{path}: the output would replace an input")
    for path in targets[0]:
        check(path, "curves")
    if summary is not None:
        if summary.suffix.lower() != ".csv":
            raise Mistake(f"{summary}: the summary is a .csv")
        if summary.resolve() in given or str(summary).casefold() in whose:
            raise Mistake(f"{summary}: the summary would replace a file of this run")
    for folder in {path.parent for paths in targets for path in paths}:
        folder.mkdir(parents=True, exist_ok=True)
    if summary is not None and not summary.parent.is_dir():
        raise Mistake(f"{summary.parent}: no such folder for the summary")


def fit_all(
    sources: list[Path],
    targets: list[list[Path]],
    how: How,
    *,
    jobs: int | None,
    unit: Unit,
    summary: Path | None,
    quiet: bool,
    verbose: bool,
) -> int:
    """Fit every source and write its targets; print the summary; return 1 where some failed, else 0.

    Workers read and fit; files are written here, so that no process that ends leaves half a file.
    """
    from cadfit.batch import Failure, result_of, row, warn_again, write_rows
    from cadfit.stages import times
    from cadfit.workers import outcomes

    size = {k: source.stat().st_size if source.is_file() else 0 for k, source in enumerate(sources)}
    tasks = {k: (sources[k], how, unit.value) for k in sorted(size, key=lambda k: -size[k])}
    rows: dict[int, dict[str, Any]] = {}
    took: dict[str, float] = {}
    with busy("fitting", quiet, len(sources)) as progress, closing(outcomes(_curves_of, tasks, None, jobs)) as coming:
        for count, (k, outcome) in enumerate(coming, 1):
            warn_again(str(sources[k]), outcome)
            result, points = result_of(str(sources[k]), outcome), None
            if not isinstance(result, Failure):
                curves, points, stages = result
                with times() as writing:
                    result = _written(sources[k], targets[k], curves, unit)
                for name, seconds in (stages | writing).items():
                    took[name] = took.get(name, 0.0) + seconds
            rows[k] = row(str(sources[k]), points, result, outcome.seconds)
            if progress is not None:
                progress(count / len(sources))
    ordered = [rows[k] for k in range(len(sources))]
    if summary is not None:
        write_rows(summary, ordered)
    if verbose:
        say_times(took)
    return _reported(ordered, quiet)


def _curves_of(task: tuple[Path, How, str]) -> tuple[Any, int, dict[str, float]]:
    """Return the curves made of a file's points, how many points, and the seconds of the stages."""
    from cadfit.drawings import made, meant, named
    from cadfit.files import Curves, contents
    from cadfit.stages import times

    source, how, unit = task
    with times() as stages:
        try:
            held = contents(source, unit)
            single = held.vertices if isinstance(held, Curves) else None
            found = held if single is None else single
            curves, said = made(found, meant(how, source, found))
        except OSError as error:
            raise ValueError(error.strerror or str(error)) from error
        except ValueError as error:
            raise ValueError(str(error).removeprefix(f"{source}: ")) from error
    return named(curves, held), int(said["points read"]), stages


def _written(source: Path, targets: list[Path], curves: Any, unit: Unit) -> Any:
    """Write the curves; return them, or the failure of a file."""
    from cadfit.batch import Failure
    from cadfit.files import write

    try:
        for path in targets:
            with about(path):
                write(path, curves, unit.value)
    except OSError as error:
        return Failure(str(source), f"{error.filename}: {error.strerror}" if error.filename else str(error))
    except Mistake as error:
        return Failure(str(source), str(error))
    return curves


def _reported(rows: list[dict[str, Any]], quiet: bool) -> int:
    """Print the table of what was fitted, and to stderr what failed; return 1 where something did, else 0."""
    from cadfit.batch import text_of

    failed = [each for each in rows if each["failure"]]
    if not quiet and len(failed) < len(rows):
        print(text_of([each for each in rows if not each["failure"]]))
    if failed:
        say(f"{len(failed)} of {len(rows)} failed:")
        for each in failed:
            say(f"{each['name']}: {each['failure']}")
    return 1 if failed else 0

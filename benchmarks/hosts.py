"""What the hosts make of fitted curves: faces, extrude, revolve, offset, fillet, loft, sweep, tubes, STEP and back.

200 real curves of a corpus ($CADFIT_CORPUS, or ../shared/corpus beside the repository), the first of each family, then
the second, and so on; of at most 1,000 points, brought to a size of 100 and fitted within 0.1. An operation succeeds
when it ends within 5 seconds of processor time and its result is valid and of the right size: the length, area or
volume is what the curve's own pieces say. Each has a process of its own, for the kernel may crash or never end.

Results are appended to FILE, a line each, and what is there already is not done again: stop it and go on at will.

    .venv-build123d/bin/python benchmarks/hosts.py FILE [curves]    # the host is the one that is installed
    .venv-cadquery/bin/python benchmarks/hosts.py FILE [curves]
    .venv-cadquery/bin/python benchmarks/hosts.py FILE table
"""

from __future__ import annotations

import json
import multiprocessing
import resource
import signal
import sys
from collections import Counter, defaultdict
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from time import process_time

from rich.progress import track

import cadfit

from host_operations import OPERATIONS, SIZE, TOLERANCE, Case, Wrong, judge

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from corpus_data import ABSENT, PRESENT, curves

HOSTS = {"build123d": "host_build123d", "cadquery": "host_cadquery"}
SECONDS = 5  # of processor time, for an operation


def cases(count):
    """Yield so many fits: the first of each family, then the second, and so on."""
    seen, rows = Counter(), []
    for k, parameter in enumerate(curves(per_family=30, max_points=1000)):
        family = parameter.id.split("-")[0]
        rows.append((seen[family], k, parameter))
        seen[family] += 1
    for _, _, parameter in sorted(rows, key=lambda row: row[:2])[:count]:
        points = parameter.values[0].points
        points = (points - points.mean(axis=0)) * (SIZE / parameter.values[0].size)
        yield Case(parameter.id, cadfit.fit(points, TOLERANCE, closed=parameter.values[0].closed, effort="fast"))


def tried(operation, host, case, send):
    """Send the reason why an operation fails, or None."""
    resource.setrlimit(resource.RLIMIT_CPU, (int(process_time()) + SECONDS, resource.RLIM_INFINITY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    try:
        judge(*operation(host, case))
        send(None)
    except Wrong as error:
        send(str(error))
    except Exception as error:
        send(f"{type(error).__name__}: {error}"[:300])


def outcome(operation, host, case):
    """Return the reason why an operation fails, or None, from a process of its own."""
    receive, send = multiprocessing.Pipe(duplex=False)
    process = multiprocessing.get_context("fork").Process(target=tried, args=(operation, host, case, send.send))
    process.start()
    send.close()
    try:
        return receive.recv()
    except EOFError:
        process.join()
        return f"no end in {SECONDS} s" if process.exitcode == -signal.SIGXCPU else "the kernel crashed"
    finally:
        process.join()


def run(file, count):
    """Append what is not in the file yet."""
    name = next(name for name in HOSTS if find_spec(name))
    host = import_module(HOSTS[name])
    done = {(row["host"], row["curve"], row["operation"]) for row in rows_of(file)}
    for case in track(cases(count), host.NAME, total=count, disable=None):
        for operation, make in case.operations.items():
            if (host.NAME, case.name, operation) in done:
                continue
            row = {"host": host.NAME, "curve": case.name, "kind": case.kind, "operation": operation}
            row |= {"poles": case.fit.poles, "edges": len(case.fit.curves), "small": case.small}
            with file.open("a", encoding="utf-8") as out:
                out.write(json.dumps(row | {"reason": outcome(make, host, case)}) + "\n")


def rows_of(file):
    return [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()] if file.exists() else []


def table(rows) -> str:
    """Return a row for each operation: how many succeed in each host, and why the others do not."""
    hosts = sorted({row["host"] for row in rows})
    counts = defaultdict(Counter)
    for row in rows:
        counts[row["kind"], row["operation"], row["host"]][row["reason"] and row["reason"].split(":")[0]] += 1
    lines = [f"| | of | {' | '.join(hosts)} | else |", f"| --- | {'---: | ' * (len(hosts) + 1)}--- |"]
    for kind, operations in OPERATIONS.items():
        for operation in operations:
            found = [counts[kind, operation, host] for host in hosts]
            of = " / ".join(map(str, sorted({count.total() for count in found})))
            failed = [
                f"{host.split()[0]}: " + ", ".join(f"{n} {reason}" for reason, n in count.most_common() if reason)
                for host, count in zip(hosts, found, strict=True)
                if count.total() > count[None]
            ]
            cells = " | ".join(str(count[None]) for count in found)
            lines.append(f"| {kind}: {operation} | {of} | {cells} | {'; '.join(failed)} |")
    return "\n".join(lines)


if __name__ == "__main__":
    target, what = Path(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else "200"
    if not PRESENT:
        print(ABSENT)
    else:
        if what != "table":
            run(target, int(what))
        print(table(rows_of(target)))

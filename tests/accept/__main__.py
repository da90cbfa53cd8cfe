"""Runs every check at full count, prints a table and writes the figures as JSON.

    python -m tests.accept build/accept.json [NAME...] [--minutes M] [--again]

The JSON file keeps the last result of each check with its commit, date and run time. A second run
on the same commit runs only the checks that have not passed yet; `--again` runs every check. With
`--minutes M`, a check starts only if its last run time fits into what is left of M minutes. The
exit code is 1 if a check failed or has no result for this commit, else 0.
"""

from __future__ import annotations

import argparse
import difflib
import importlib
import json
import os
import resource
import subprocess
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from datetime import UTC, datetime
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from frictool.runtime.part_files import part_file

Check = Callable[[], dict[str, Any]]
Results = dict[str, dict[str, Any]]
ROOT = Path(__file__).parents[2]
COST_UNKNOWN_S = 300.0  # of a check that was never run


def collect(folder: Path) -> dict[str, Check]:
    """The checks of all check_*.py, by name. Raises ValueError where two have one name."""
    checks: dict[str, Check] = {}
    for path in sorted(folder.glob("check_*.py")):
        for name, check in importlib.import_module(f"tests.accept.{path.stem}").CHECKS.items():
            if name in checks:
                raise ValueError(f"two checks are called {name!r}")
            checks[name] = check
    return checks


def commit_of(root: Path) -> str:
    """Return the hash of the last commit, or an empty text if a file differs from that commit."""
    git = ["git", "-C", str(root)]
    changed = subprocess.run(
        [*git, "status", "--porcelain"], capture_output=True, text=True, check=True
    ).stdout
    if changed:
        return ""
    return subprocess.run(
        [*git, "rev-parse", "HEAD"], capture_output=True, text=True, check=True
    ).stdout.strip()


def left_to_run(names: list[str], results: Results, commit: str) -> list[str]:
    """Return the checks that have not passed at `commit`, the longest run time first.

    If `commit` is empty, all checks are returned.
    """
    left = [
        name
        for name in names
        if not commit
        or not results.get(name, {}).get("passed")
        or results[name].get("commit") != commit
    ]
    return sorted(left, key=lambda name: -cost_s(name, results))


def cost_s(name: str, results: Results) -> float:
    """Return the wall time of the check's last run [s]."""
    return float(results.get(name, {}).get("seconds", COST_UNKNOWN_S))


def run(
    checks: dict[str, Check], costs: dict[str, float], most_s: float
) -> Iterator[tuple[str, dict[str, Any]]]:
    """Run each check in a process of its own and yield the results as the checks end.

    A check starts only if it would end within `most_s` seconds of the start of the run, judged by
    `costs`, the last run times [s]. The first checks, one per core, start regardless of this limit.
    """
    _started.update(checks)
    waiting, first = list(checks), True
    start = time.perf_counter()
    cores = max(1, min(len(checks), os.cpu_count() or 1))
    with ProcessPoolExecutor(cores, get_context("fork")) as pool:
        running: dict[Future[dict[str, Any]], str] = {}
        while True:
            spent = time.perf_counter() - start
            fitting = [name for name in waiting if spent + costs[name] <= most_s]
            if first:  # a check longer than the limit is run all the same, at the start
                fitting, first = waiting, False
            for name in fitting[: cores - len(running)]:
                waiting.remove(name)
                running[pool.submit(one, name)] = name
            if not running:
                return
            for done in wait(running, return_when=FIRST_COMPLETED).done:
                yield running.pop(done), done.result()


_started: dict[str, Check] = {}  # as a process inherits them


def one(name: str) -> dict[str, Any]:
    """Return the result of a check; one that raises has failed, with the exception as its error."""
    start, spent = time.perf_counter(), processor_s()
    try:
        result = _started[name]()
    except Exception as error:  # one broken check must not hide the others
        traceback.print_exc()
        result = {"passed": False, "error": f"{type(error).__name__}: {error}"}
    return {
        **result,
        "passed": bool(result["passed"]),
        "seconds": round(time.perf_counter() - start, 2),
        "processor_s": round(processor_s() - spent, 2),
    }


def processor_s() -> float:
    """Return the processor time of this process and its ended children [s]."""
    spent = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(each.ru_utime + each.ru_stime for each in spent)


ADDED = ("passed", "seconds", "processor_s", "commit", "date")  # by this program


def row(name: str, result: dict[str, Any]) -> str:
    figures = {
        key: value
        for key, value in result.items()
        if key not in ADDED and not isinstance(value, dict | list)
    }
    shown = ", ".join(
        f"{key} {value:.4g}" if isinstance(value, float) else f"{key} {value}"
        for key, value in figures.items()
    )
    return (
        f"{'passed' if result['passed'] else 'FAILED'}  {name:<36} {result['seconds']:>7.1f} "
        f"s  {shown}"
    )


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tests.accept",
        description="Runs checks at full count, prints a table and writes the figures as JSON. "
        "Exit code 1 where one fails.",
        epilog='Example: python -m tests.accept build/accept.json "annex C: gamma"',
    )
    parser.add_argument("target", type=Path, help="the JSON file to write")
    parser.add_argument(
        "names", nargs="*", metavar="NAME", help="only these checks; all where none is named"
    )
    parser.add_argument(
        "--minutes",
        type=float,
        metavar="M",
        default=float("inf"),
        help="begin no check whose last run took longer than what is left of M minutes",
    )
    parser.add_argument(
        "--again", action="store_true", help="also run what has passed at this commit"
    )
    return parser


def main(arguments: list[str]) -> int:
    parser = _parser()
    options = parser.parse_args(arguments)
    target = options.target
    checks = collect(Path(__file__).parent)
    for wrong in (name for name in options.names if name not in checks):
        near = difflib.get_close_matches(wrong, checks, n=1)
        parser.error(
            f"there is no check {wrong!r}{f'; did you mean {near[0]!r}?' if near else ';'} "
            f"allowed: {', '.join(checks)}"
        )
    commit = commit_of(ROOT)
    names = options.names or list(checks)
    results: Results = json.loads(target.read_text()) if target.exists() else {}
    left = left_to_run(names, results, "" if options.again else commit)
    costs = {name: cost_s(name, results) for name in left}
    target.parent.mkdir(parents=True, exist_ok=True)
    ended = set(names) - set(left)
    for name, result in run({name: checks[name] for name in left}, costs, 60.0 * options.minutes):
        ended.add(name)
        results[name] = {**result, "commit": commit, "date": f"{datetime.now(UTC):%Y-%m-%d}"}
        print(row(name, result), flush=True)
        with part_file(target) as stream:
            stream.write((json.dumps(results, indent=2, default=float) + "\n").encode())
    not_passed = [name for name in names if name not in ended or not results[name]["passed"]]
    print(
        f"{len(names) - len(not_passed)} of {len(names)} checks passed at "
        f"{commit[:8] or 'the edited files'}; figures in {target}"
    )
    for name in not_passed:
        state = "failed" if name in ended else f"not run ({costs[name] / 60.0:.1f} min)"
        print(f"  {state}: {name}")
    return 1 if not_passed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

"""Runs every check at full count, prints a table and writes the figures as JSON.

    python -m tests.accept build/accept.json [NAME...]

With names, only those checks; --help says more. Exit code 1 where one fails.
"""

from __future__ import annotations

import argparse
import difflib
import importlib
import json
import os
import sys
import time
import traceback
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from typing import Any

Check = Callable[[], dict[str, Any]]


def collect(folder: Path) -> dict[str, Check]:
    """The checks of all check_*.py, by name. Raises ValueError where two have one name."""
    checks: dict[str, Check] = {}
    for path in sorted(folder.glob("check_*.py")):
        for name, check in importlib.import_module(f"tests.accept.{path.stem}").CHECKS.items():
            if name in checks:
                raise ValueError(f"two checks are called {name!r}")
            checks[name] = check
    return checks


def run(checks: dict[str, Check]) -> dict[str, dict[str, Any]]:
    """Run each check in a process of its own; return the results."""
    _started.update(checks)
    with ProcessPoolExecutor(min(len(checks), os.cpu_count() or 1), get_context("fork")) as pool:
        asked = {pool.submit(one, name): name for name in checks}
        for done in as_completed(asked):
            print(row(asked[done], done.result()), flush=True)
        return {name: done.result() for done, name in asked.items()}


_started: dict[str, Check] = {}  # as a process inherits them


def one(name: str) -> dict[str, Any]:
    """Return the result of a check; one that raises has failed, with the exception as its error."""
    start = time.perf_counter()
    try:
        result = _started[name]()
    except Exception as error:  # one broken check must not hide the others
        traceback.print_exc()
        result = {"passed": False, "error": f"{type(error).__name__}: {error}"}
    return {
        **result,
        "passed": bool(result["passed"]),
        "seconds": round(time.perf_counter() - start, 2),
    }


def row(name: str, result: dict[str, Any]) -> str:
    figures = {
        key: value
        for key, value in result.items()
        if key not in ("passed", "seconds") and not isinstance(value, dict | list)
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
    return parser


def main(arguments: list[str]) -> int:
    parser = _parser()
    asked = parser.parse_args(arguments)
    target, names = asked.target, asked.names
    checks = collect(Path(__file__).parent)
    for wrong in (name for name in names if name not in checks):
        near = difflib.get_close_matches(wrong, checks, n=1)
        parser.error(
            f"there is no check {wrong!r}{f'; did you mean {near[0]!r}?' if near else ';'} "
            f"allowed: {', '.join(checks)}"
        )
    results = run({name: check for name, check in checks.items() if not names or name in names})
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(json.dumps(results, indent=2, default=float) + "\n")
    failed = [name for name, result in results.items() if not result["passed"]]
    print(f"{len(results) - len(failed)} of {len(results)} checks passed; figures in {target}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

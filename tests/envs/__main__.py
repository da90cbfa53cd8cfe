"""Runs the tests and the chain in other environments, prints a line each and writes the figures as
JSON.

    python -m tests.envs build/envs.json [NAME...] [--paths tests/lmi ...]          make test-envs

Prescott, Haswell, Zen, SkylakeX: the tests with OpenBLAS's kernels for that processor, where this
one can run them, with one or two threads; --paths: only these tests. lowest, newest: the whole
chain with the lowest and the newest versions of all dependencies, which are installed from PyPI.
Without names, all. Exit code 1 where one fails.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from tests.envs import dependencies, processors

NAMES = (*dependencies.ENVIRONMENTS, *processors.ENVIRONMENTS)


def made(name: str, paths: tuple[str, ...]) -> dict[str, Any]:
    """Result of the tests in one environment."""
    if name in dependencies.ENVIRONMENTS:
        return dependencies.ENVIRONMENTS[name]()
    return processors.ENVIRONMENTS[name](paths)


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m tests.envs",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("target", type=Path, help="the JSON file to write")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(NAMES)}")
    parser.add_argument("--paths", nargs="+", default=[], help="only these tests")
    asked = parser.parse_args(arguments)
    for wrong in (name for name in asked.names if name not in NAMES):
        parser.error(f"there is no environment {wrong!r}; allowed: {', '.join(NAMES)}")
    results = {}
    for name in asked.names or NAMES:
        results[name] = made(name, tuple(asked.paths))
        told = ", ".join(
            f"{key} {value}" for key, value in results[name].items() if key != "passed" and value
        )
        print(f"{'passed' if results[name]['passed'] else 'FAILED'}  {name:<10} {told}", flush=True)
    asked.target.parent.mkdir(parents=True, exist_ok=True)
    asked.target.write_text(json.dumps(results, indent=2) + "\n")
    return 0 if all(one["passed"] for one in results.values()) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

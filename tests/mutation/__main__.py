"""Mutation testing of the numerical packages.

    python -m tests.mutation build/mutation.json [--count N] [--seed TEXT] [--budget S] [--only
    FILE:LINE ...]

Draws N lines by the hash of the last commit, edits each once in a clone, and runs the tests that
reach its module. Exit code 1 if an edit survives. A survivor is an edit that no test notices, or an
equivalent program: a person decides which. The same command on the same commit goes on where it was
interrupted.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

from tests.mutation.mutants import Mutant, draw, mutants_of
from tests.mutation.tree import Tree
from tests.support.commit_hash import commit_hash

PACKAGES = [
    "engine",
    "friction",
    "control",
    "identify",
    "verify",
    "metrics",
    "observe",
    "lmi",
    "campaign/statistics",
]
ROOT = Path(__file__).parents[2]


def main(arguments: list[str]) -> int:
    """Run the mutants, print a line each, write a table as JSON; return 1 if one survives."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.mutation", description="Mutation testing of the numerical packages."
    )
    parser.add_argument("target", type=Path, help="the JSON file to write")
    parser.add_argument("--count", type=int, default=100, help="number of lines to draw")
    parser.add_argument("--seed", help="seed of the draw; the hash of the last commit by default")
    parser.add_argument(
        "--budget", type=float, default=600.0, help="time for the tests of one mutant [s]"
    )
    parser.add_argument(
        "--only",
        nargs="*",
        metavar="FILE:LINE",
        help="every mutant of these lines instead of a draw",
    )
    options = parser.parse_args(arguments)
    commit = commit_hash()
    seed = options.seed or commit
    folders = [f"frictool/{package}" for package in PACKAGES]
    mutants = of_lines(options.only) if options.only else draw(ROOT, folders, options.count, seed)
    options.target.parent.mkdir(parents=True, exist_ok=True)
    tree = Tree(ROOT, options.target.with_suffix(".tree").absolute())
    rows = finished(options.target, commit, seed)
    done = {(row["path"], row["start"], row["replacement"]) for row in rows}
    for mutant in mutants:
        if (mutant.path, mutant.start, mutant.replacement) in done:
            continue
        outcome = tree.judge(mutant, options.budget)
        rows.append({**asdict(mutant), **asdict(outcome)})
        print(
            f"{outcome.status:<11} {outcome.seconds:6.1f} s  {mutant}  {outcome.test}", flush=True
        )
        options.target.write_text(
            json.dumps({"commit": commit, "seed": seed, "mutants": rows}, indent=2) + "\n"
        )
    killed = sum(row["status"] == "killed" for row in rows)
    print(f"{killed} of {len(rows)} mutants killed; figures in {options.target}")
    return 0 if killed == len(rows) else 1


def finished(target: Path, commit: str, seed: str) -> list[dict[str, Any]]:
    """Return the rows of an interrupted run of the same commit and seed."""
    kept = json.loads(target.read_text()) if target.exists() else {}
    return list(kept["mutants"]) if (kept.get("commit"), kept.get("seed")) == (commit, seed) else []


def of_lines(places: list[str]) -> list[Mutant]:
    """Return every mutant of the lines `FILE:LINE`."""
    found = []
    for place in places:
        path, line = place.rsplit(":", 1)
        found += [
            mutant
            for mutant in mutants_of(path, (ROOT / path).read_text())
            if mutant.line == int(line)
        ]
    return found


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

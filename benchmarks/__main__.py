"""Runs every benchmark, prints a table and writes the rows as JSON.

    python -m benchmarks build/bench.json [ID...]

With ids, only those rows; --help says more. ratio > 1 means ours is better. A row whose peer is not
installed is skipped, and the reason printed. Exit code 1 where a row fails.
"""

from __future__ import annotations

import argparse
import difflib
import importlib
import json
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

KEYS = ("id", "peer", "ours", "theirs", "unit", "ratio", "accuracy")
Row = Callable[[], dict[str, Any]]


def collect(folder: Path) -> list[Row]:
    """The rows of all bench_*.py, in order."""
    return [
        row
        for path in sorted(folder.glob("bench_*.py"))
        for row in importlib.import_module(f"benchmarks.{path.stem}").ROWS
    ]


def shown(row: dict[str, Any]) -> str:
    numbers = f"{row['ours']:>10.4g} {row['theirs']:>10.4g} {row['unit']:<12} {row['ratio']:>8.3g}"
    return f"{row['id']:<24} {row['peer']:<28} {numbers}  {row['accuracy']}"


def run(rows: list[Row], ids: list[str]) -> tuple[list[dict[str, Any]], int]:
    """The finished rows, and how many failed."""
    done, failed = [], 0
    print(
        f"{'id':<24} {'peer':<28} {'ours':>10} {'theirs':>10} {'unit':<12} {'ratio':>8}  accuracy"
    )
    for row in rows:
        if ids and name_of(row) not in ids:
            continue
        try:
            found = {"id": name_of(row)} | row()
            done.append({key: found[key] for key in KEYS} | found)
            print(shown(found), flush=True)
        except ModuleNotFoundError as missing:
            if (missing.name or "").partition(".")[0] in ("frictool", "benchmarks", "studies"):
                raise
            print(f"{name_of(row):<24} skipped: {missing.name} is not installed")
        except Exception:  # one broken row must not hide the others
            failed += 1
            traceback.print_exc()
            print(f"{name_of(row):<24} FAILED")
    return done, failed


def name_of(row: Row) -> str:
    """A row's id: its function's attribute `id`, else from its name: `log_read` is log.read."""
    return getattr(row, "id", None) or row.__name__.replace("_", ".", 1)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks",
        description="Times frictool against its peers, prints a table and writes the rows as "
        "JSON. Exit code 1 where a row fails.",
        epilog="Example: python -m benchmarks build/bench.json mechanism.real_time",
    )
    parser.add_argument("target", type=Path, help="the JSON file to write")
    parser.add_argument(
        "ids",
        nargs="*",
        metavar="ID",
        help="only these rows, such as log.read; all where none is named",
    )
    return parser


def main(arguments: list[str]) -> int:
    parser = _parser()
    asked = parser.parse_args(arguments)
    rows = collect(Path(__file__).parent)
    names = [name_of(row) for row in rows]
    for wrong in (name for name in asked.ids if name not in names):
        near = difflib.get_close_matches(wrong, names, n=1)
        parser.error(
            f"there is no row {wrong!r}{f'; did you mean {near[0]}?' if near else ';'} allowed: "
            f"{', '.join(names)}"
        )
    done, failed = run(rows, asked.ids)
    asked.target.parent.mkdir(parents=True, exist_ok=True)
    asked.target.write_text(json.dumps(done, indent=2, default=float) + "\n")
    print(f"{len(done)} rows; figures in {asked.target}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

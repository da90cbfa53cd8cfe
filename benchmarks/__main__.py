"""Run the benchmarks, print a table, and write its rows as JSON.

    python -m benchmarks build/bench.json [ID...]

With IDs, only these rows are computed. A ratio above 1 means that frictool is better than the peer.
If a peer is not installed, its rows are skipped, and the reason is printed. The exit code is 1 if a
row fails.
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
    """Return the row functions of all files bench_*.py, in the order of the files."""
    return [
        row
        for path in sorted(folder.glob("bench_*.py"))
        for row in importlib.import_module(f"benchmarks.{path.stem}").ROWS
    ]


def shown(row: dict[str, Any]) -> str:
    numbers = f"{row['ours']:>10.4g} {row['theirs']:>10.4g} {row['unit']:<12} {row['ratio']:>8.3g}"
    return f"{row['id']:<24} {row['peer']:<28} {numbers}  {row['accuracy']}"


def run(rows: list[Row], ids: list[str]) -> tuple[list[dict[str, Any]], int]:
    """Compute and print the rows; return the finished rows and the number of failed rows."""
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
    """Return the ID of a row function: its attribute `id`, by default from its name.

    The function log_read has the default ID log.read.
    """
    return getattr(row, "id", None) or row.__name__.replace("_", ".", 1)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks",
        description="Time frictool and its peers, print a table, and write the rows as JSON. The "
        "exit code is 1 if a row fails.",
        epilog="Example: python -m benchmarks build/bench.json mechanism.real_time",
    )
    parser.add_argument("target", type=Path, help="JSON file to write")
    parser.add_argument(
        "ids",
        nargs="*",
        metavar="ID",
        help="only these rows, such as log.read; by default all",
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

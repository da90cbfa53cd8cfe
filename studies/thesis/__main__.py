"""Reproduction of the thesis's tables and main figures, as a page, as JSON and as a summary.

    python -m studies.thesis build/thesis [PART...]           make thesis

The command writes index.html and tables.json, with the named parts or with all of them. The exit
code is 1 if

- a value differs by more than its tolerance, without a reason in words.yaml,
- a reason is no longer needed, or
- a value or a figure is missing.
"""

from __future__ import annotations

import importlib
import os
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import active_children, get_context
from pathlib import Path

from studies.thesis.results import Part

PARTS = {  # name -> contents, the slowest first, so that all cores stay busy
    "laws": "tables 2.1, 3.2; figures 3.11 to 3.25",
    "clutch_loops": "table 5.3, 5.4; annex C.5.3",
    "observers": "chapter 6",
    "clutch_model": "tables 4.6, 4.7; 4.4",
    "identification": "tables 4.2 to 4.4; 4.2, 4.3",
    "mass_loops": "5.2.4, 5.2.5",
    "synthesis": "5.4.3.1; annex C.5.2",
    "mechanism": "figures 2.12 to 2.14",
    "inputs": "tables 3.1, 4.1, 4.5, 4.8, 5.1, 5.2",
}


def made(name: str) -> tuple[Part, str]:
    """Return a part, or the traceback of its exception; the other parts continue."""
    try:
        make: Callable[[], Part] = getattr(
            importlib.import_module(f"studies.thesis.parts.{name}"), name
        )
        return make(), ""
    except Exception:  # reported with the results; the exit code is then 1
        return Part(), traceback.format_exc()


def collected(names: list[str]) -> tuple[Part, list[str]]:
    """Compute the parts, one per process, and join them; also return their errors.

    Progress is printed to stderr.
    """
    start, whole, wrong = time.monotonic(), Part(), []
    for done, (name, part, broken) in enumerate(_each(names), start=1):
        _join(whole, part)
        if broken:
            wrong.append(f"{name}: {broken.strip().splitlines()[-1]}")
            print(broken, file=sys.stderr)
        contents = f"{len(part.values)} tables, {len(part.figures)} figures"
        print(
            f"{time.monotonic() - start:6.0f} s  {done} of {len(names)}  {name}: {contents}",
            file=sys.stderr,
            flush=True,
        )
    return whole, wrong


def _each(names: list[str]) -> Iterator[tuple[str, Part, str]]:
    """Yield name, part and traceback of each part as it is done.

    A single part is computed in this process.
    """
    if len(names) == 1:
        yield names[0], *made(names[0])
        return
    with ProcessPoolExecutor(min(len(names), os.cpu_count() or 1), get_context("fork")) as pool:
        asked = {pool.submit(made, name): name for name in names}
        try:
            for future in as_completed(asked):
                yield asked[future], *future.result()
        except BaseException:  # interrupted: the other parts are not awaited
            pool.shutdown(wait=False, cancel_futures=True)
            for child in active_children():
                child.terminate()
            raise


def _join(whole: Part, part: Part) -> None:
    for table, values in part.values.items():
        whole.add(table, {**values})
    for number, drawn in part.figures.items():
        whole.draw(number, drawn.caption, *drawn.svgs)
    for table, lines in part.notes.items():
        for line in lines:
            whole.say(table, line)


def main(arguments: list[str]) -> int:
    if not arguments or arguments[0].startswith("-"):
        print(__doc__, file=sys.stderr)
        return 0 if arguments and arguments[0] in ("-h", "--help") else 2
    target, names = Path(arguments[0]), arguments[1:] or list(PARTS)
    unknown = [name for name in names if name not in PARTS]
    if unknown:
        print(
            f"no part is called {', '.join(unknown)}; there are: {', '.join(PARTS)}",
            file=sys.stderr,
        )
        return 2
    if target.exists() and not target.is_dir():
        print(f"{target}: is a file; name a folder", file=sys.stderr)
        return 2
    try:  # before the computation, which takes minutes
        target.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        print(f"error: {target.parent}: cannot be made: {error.strerror}", file=sys.stderr)
        return 3
    return _make(target, list(dict.fromkeys(names)))


def _make(target: Path, names: list[str]) -> int:
    """Make the parts, write the folder and return the exit code."""
    from frictool.cli.output_folder import save_folder
    from frictool.errors import FrictoolError
    from studies.thesis.comparison import Comparison, compare
    from studies.thesis.documents import read
    from studies.thesis.page import page
    from studies.thesis.summary import as_json, summary

    try:
        documents = read()
    except ValueError as error:
        print(f"error: {error}", file=sys.stderr)
        return 3
    part, wrong = collected(names)
    chosen = None if len(names) == len(PARTS) else frozenset({*part.values, *part.figures})
    found = compare(documents, part, chosen)
    found = Comparison(found.tables, (*wrong, *found.problems))
    files = {
        "index.html": page(documents, part, found),
        "tables.json": as_json(documents, part, found),
    }
    print("\n".join(summary(documents, part, found)))
    try:
        save_folder(target, files, [], overwrite=True)
    except FrictoolError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_code
    print(f"\npage: {target / 'index.html'}; figures as JSON: {target / 'tables.json'}")
    return 1 if found.problems else 0


if __name__ == "__main__":
    try:
        code = main(sys.argv[1:])
    except KeyboardInterrupt:
        print("interrupted: nothing was written", file=sys.stderr)
        code = 130
    sys.exit(code)

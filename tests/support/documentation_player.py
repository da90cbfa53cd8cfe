"""Plays the `sh` and `python` blocks of a page in a scratch copy, and holds what they print against
the `text` block beneath them.

A page starts at the top of the copy; a line `cd FOLDER` goes on from there. `# exit code 1` behind
a command is what it has to end with, 0 without. `frictool` runs in the test's process, any other
line in a shell. A line `...` of a `text` block stands for any number of lines, and a last word
`...` for the rest of a line, where that depends on the processor; everything else has to be
printed, in this order and without a line between.
"""

from __future__ import annotations

import io
import math
import operator
import os
import re
import shlex
import shutil
import subprocess
import sys
from contextlib import redirect_stdout
from decimal import Decimal
from pathlib import Path
from typing import Any

import pytest

from studies.command_line import run
from tests.support.documentation_pages import ROOT, blocks, name_of, text_of

NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
VERTEX = re.compile(r"\bv\d+\b")
EXIT = re.compile(r"\s+# exit code (\d)\b.*$")
COMMENT = re.compile(r"\s+#.*$")
SOLVED = re.compile(
    r"synth|controller|campaign|run\.mcap|run\.main|observer"
)  # in commands: a controller that was synthesised is used
# allowed difference of figures that follow from a synthesised controller: relative, or in units of
# the last digit of a decimal fraction
PART, UNITS = Decimal("0.15"), 10
# the fit of a simulated motion is iterative: its figures may differ by UNITS of the last digit
ITERATIVE = re.compile(r"^output-error:", re.M)
CELLS = re.compile(r"\(\d+ cells\b")  # of a proof: how many it takes is not promised
STEP = re.compile(r"\bstep \d+ at [\d.]+ s\b")  # in which a requirement's figure is worst
RELATION = re.compile(rf"({NUMBER.pattern})(?: *[^\s\d<>=]+)? *(<=|>=|<|>) *({NUMBER.pattern})")
JUDGED = Decimal(
    "0.5"
)  # by which a figure with a limit may differ, where it keeps to the same side
HOLDS = {"<=": operator.le, ">=": operator.ge, "<": operator.lt, ">": operator.gt}
NOTEBOOK_SECONDS = 1200  # of one cell: the first one may compile kernels
DATA = Path(os.environ.get("FRICTOOL_DATA", ROOT.parent / "shared" / "data"))


def scratch(folder: Path) -> Path:
    """A copy of what the commands of the documentation read, as a clone has it before anything was
    made."""
    for name in ("sample_logs", "configs"):
        shutil.copytree(
            ROOT / name, folder / name, ignore=shutil.ignore_patterns("build", "__pycache__")
        )
    return folder


def play(page: Path, folder: Path, patch: pytest.MonkeyPatch, before: str = "") -> str:
    """Runs the page's blocks in `folder` and returns all that they printed.

    before: heading at which it stops; by default it runs the whole page. Fails where a command does
    not end, or what it prints is not, as the page says.
    """
    patch.chdir(folder)
    patch.setenv("FRICTOOL_DATA", str(DATA.resolve()))
    everything = printed = ""
    names: dict[str, Any] = {"__name__": name_of(page)}
    shown_by, solved = "", False
    end = text_of(page).partition(f"\n{before}\n")[0].count("\n") + 1 if before else math.inf
    for block in blocks(page, "sh", "python", "console", "text"):
        if block.line > end:
            break
        if block.language == "text" and shown_by == "console":
            continue  # tests/accept/check_docs.py
        shown_by = block.language
        solved = bool(SOLVED.search(block.text)) if block.language != "text" else solved
        if block.language == "sh":
            printed = "".join(_run(line, patch) for line in block.lines)
            everything += printed
        elif block.language == "python":
            with redirect_stdout(io.StringIO()) as out:
                exec(compile(block.text, f"{page}:{block.line}", "exec"), names)
            printed = out.getvalue()
            everything += printed
        elif block.language == "text":
            units = UNITS if ITERATIVE.search(printed) else 1
            missing = first_missing(printed.splitlines(), block.lines, solved, units)
            assert missing is None, (
                f"{name_of(page)}, block at line {block.line}: not printed so: {missing!r}; "
                f"printed was\n{printed}"
            )
    return everything


def run_notebook(text: str, folder: Path) -> str:
    """Run the notebook of a page's text in `folder`, and return what its cells print."""
    from nbclient import NotebookClient

    from release.notebook import notebook

    made = notebook(text)
    resources = {"metadata": {"path": str(folder)}}
    NotebookClient(
        made, timeout=NOTEBOOK_SECONDS, kernel_name="python3", resources=resources
    ).execute()
    return "".join(
        output.get("text", "") for cell in made.cells for output in cell.get("outputs", [])
    )


def _run(line: str, patch: pytest.MonkeyPatch) -> str:
    expected = int(match[1]) if (match := EXIT.search(line)) else 0
    *first, last = COMMENT.sub("", line).split(" && ")
    return "".join([*(_ended(one, 0, patch) for one in first), _ended(last, expected, patch)])


def _ended(command: str, expected: int, patch: pytest.MonkeyPatch) -> str:
    """Run a command, assert its exit code, and return what it printed."""
    if command.startswith("cd "):
        patch.chdir(command[3:].strip())
        return ""
    if command.startswith("frictool ") and not re.search(r"[|;&<>*]", command):
        result = run(*map(os.path.expandvars, shlex.split(command)[1:]))
        code, out = result.code, result.stdout + result.stderr
    else:
        path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
        done = subprocess.run(
            ["bash", "-c", command],
            capture_output=True,
            text=True,
            env={**os.environ, "PATH": path},
        )
        code, out = done.returncode, done.stdout + done.stderr
    assert code == expected, f"{command}\nended with {code}, not {expected}\n{out}"
    return out


def agrees(printed: str, page: str, solved: bool = False, units: int = 1) -> bool:
    """Return whether the words are the same and numbers differ by at most `units` units of the
    page's last digit.

    solved: the figures follow from a solver or a search, whose last digits depend on the processor.
    They are held to what is promised: the same words, each printed inequality true or false as on
    the page, figures within PART or UNITS, whole numbers within PART (so that small ones are
    equal), figures before a limit within JUDGED. The vertex and the step that are worst, and the
    number of cells of a proof, are not promised.
    """
    if page.endswith(" ..."):
        words = page.split()[:-1]
        printed, page = " ".join(printed.split()[: len(words)]), " ".join(words)
    if solved:
        printed, page = (
            STEP.sub("step", CELLS.sub("(# cells", VERTEX.sub("v", text)))
            for text in (printed, page)
        )
    if NUMBER.sub("#", printed).split() != NUMBER.sub("#", page).split():
        return False
    if solved:
        if not all(
            _on_the_same_side(*pair)
            for pair in zip(RELATION.findall(printed), RELATION.findall(page), strict=True)
        ):
            return False
        printed, page = RELATION.sub(r"\3", printed), RELATION.sub(r"\3", page)
    pairs = zip(NUMBER.findall(printed), NUMBER.findall(page), strict=True)
    return all(
        abs(Decimal(found) - Decimal(said)) <= _allowed(said, solved, units)
        for found, said in pairs
    )


def _allowed(number: str, solved: bool, units: int) -> Decimal:
    unit, size = _unit(number), abs(Decimal(number))
    if not solved:
        return units * unit
    return size * PART if unit == 1 else max(UNITS * unit, size * PART)


def _on_the_same_side(printed: tuple[str, str, str], page: tuple[str, str, str]) -> bool:
    """Return whether two inequalities (number, sign, number) are both true or both false, and their
    first numbers agree within JUDGED."""
    held = [HOLDS[sign](Decimal(left), Decimal(right)) for left, sign, right in (printed, page)]
    room = max(UNITS * _unit(page[0]), abs(Decimal(page[0])) * JUDGED)
    return held[0] == held[1] and abs(Decimal(printed[0]) - Decimal(page[0])) <= room


def _unit(number: str) -> Decimal:
    """One unit of the last digit of a number as it is written."""
    return Decimal((0, (1,), int(Decimal(number).as_tuple().exponent)))


def first_missing(
    printed: list[str], page: list[str], solved: bool = False, units: int = 1
) -> str | None:
    """The first line of a `text` block that was not printed where the block says it; None where all
    were. Blank lines do not count."""
    printed = [line for line in printed if line.strip()]
    pieces: list[list[str]] = [[]]
    for line in page:
        if line.strip() == "...":
            pieces.append([])
        else:
            pieces[-1].append(line)
    at = 0
    for number, piece in enumerate(pieces):
        last = len(printed) - len(piece)
        starts = range(at, last + 1)
        if number == 0:
            starts = range(min(1, last + 1))
        if number == len(pieces) - 1:
            starts = range(last, last + 1) if last in starts else range(0)
        found = next(
            (
                start
                for start in starts
                if all(
                    agrees(*pair, solved, units)
                    for pair in zip(printed[start:], piece, strict=False)
                )
            ),
            None,
        )
        if found is None:
            return next(
                (
                    said
                    for said in piece
                    if not any(agrees(line, said, solved, units) for line in printed[at:])
                ),
                piece[0] if piece else "the end",
            )
        at = found + len(piece)
    return None

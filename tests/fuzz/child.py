"""Runs mutated inputs one after the other through `ingest`, `ingest --salvage` and `info`, in a
process with limits.

    python -m tests.fuzz.child NAME SEED FIRST COUNT

Prints `at INDEX` before each input and `found INDEX: WHY` after one that did what no input may. A
hang ends the process (exit code 1, the stacks on stderr), and so does a crash; whoever started it
goes on behind it.
"""

from __future__ import annotations

import faulthandler
import resource
import shutil
import sys
import tempfile
import zlib
from pathlib import Path

import numpy as np

from frictool.errors import LogError
from frictool.logs.canonical.mcap_format import read_mcap
from studies.command_line import CommandResult, run
from tests.support import sample_files
from tests.support.file_mutations import mutated

LONGEST = 10.0  # s for one input
MOST_BYTES = 1 << 30  # beyond what the process has when it has read the unchanged sample
INPUT = "input"
# how a text file or a bag was taken, and what of it was guessed
KNOWN_LINES = (
    "error: ",
    "warning: ",
    f"{INPUT}: ",
    f"{INPUT} does not determine all values; ",
    "x_",
    "guessed ",
    "cannot be read and left out: ",
    "columns.",
    "  columns.",
)
LONGEST_LINE = 1000  # characters of a line
LONGEST_MESSAGE = 200  # characters of an error or warning, without the folder


def input_of(name: str, data: bytes, seed: int, index: int) -> bytes:
    """The input with this number: the same whichever process makes it."""
    return mutated(data, np.random.default_rng([seed, zlib.crc32(name.encode()), index]))


def command(name: str, index: int, path: Path, bench: Path, target: Path) -> list[str | Path]:
    """Return the command for an input: ingest, info or ingest --salvage in turn; info or --guess
    for a logger; info for a document."""
    if name == sample_files.DOCUMENT:
        return ["info", bench, "--bench", path, "--json"]
    if name.startswith(sample_files.LOGGER):
        guess: list[str | Path] = [
            "ingest",
            "--guess",
            path,
            *(["--axis", "rotary"] if index % 4 else []),
            "-o",
            "-",
        ]
        return guess if index % 2 else ["info", path]
    if index % 3 == 1:
        return ["info", path, "--bench", bench, "--json"]
    return [
        "ingest",
        path,
        "--bench",
        bench,
        "-o",
        target,
        *(["--salvage"] if index % 3 == 2 else []),
    ]


def complaint(result: CommandResult, target: Path, before: set[str], salvage: bool) -> str | None:
    """Return the error in a command's behaviour, or None. before: names in the folder before it
    ran; salvage: if an error may leave an output."""
    lines = result.stderr.splitlines()
    errors = [line for line in lines if line.startswith("error: ")]
    left = {path.name for path in target.parent.iterdir()} - before
    if result.code not in (0, 3):
        return f"exit code {result.code}: {result.stderr}"
    if (
        any(not line.startswith(KNOWN_LINES) for line in lines)
        or max(map(len, lines), default=0) > LONGEST_LINE
    ):
        return f"no messages of one line: {result.stderr[:LONGEST_LINE]}"
    for line in lines:
        short = line.replace(f"{target.parent}/", "")
        if short.startswith(("error: ", "warning: ")) and len(short) > LONGEST_MESSAGE:
            return f"a message of {len(short)} characters: {short}"
    if len(errors) > 1 or (result.code == 3 and not lines):
        return f"exit code 3 needs one line that says why: {lines}"
    if left - {target.name}:
        return f"left behind: {left}"
    if errors and target.name in left and not salvage:
        return "an output beside an error"
    if target.name in left:
        try:
            read_mcap(target)
        except LogError as error:
            return f"wrote what cannot be read: {error}"
    return None


def place_for(sample: Path, folder: Path) -> Path:
    """The file in `folder` that inputs are written to, with the rest of its bag beside it where the
    sample is a part of one."""
    whole = sample_files.given(sample)
    if whole == sample:
        return folder / INPUT
    shutil.copytree(whole, folder / INPUT)
    return folder / INPUT / sample.name


def attempt(
    name: str, index: int, data: bytes, path: Path, bench: Path, longest: float = LONGEST
) -> str | None:
    """Return the forbidden behaviour on one input, written to `path`, or None; the bench lies in
    the folder of both. longest: s."""
    folder = bench.parent
    target = folder / "out.mcap"
    path.write_bytes(data)
    before = {one.name for one in folder.iterdir()}
    faulthandler.dump_traceback_later(longest, exit=True, file=sys.__stderr__)
    try:
        words = command(name, index, sample_files.given(path), bench, target)
        return complaint(run(*words), target, before, "--salvage" in words)
    except MemoryError:
        return "took more memory than it may"
    except Exception as error:  # what the command does not foresee is a traceback for its user
        return f"{type(error).__name__}: {error}"
    finally:
        faulthandler.cancel_dump_traceback_later()
        for one in folder.iterdir():
            if one.name not in before:
                one.unlink()


def limit_memory() -> None:
    """Nothing beyond MOST_BYTES from here on."""
    pages = int(Path("/proc/self/statm").read_text().split()[5])  # data and stack
    allowed = pages * resource.getpagesize() + MOST_BYTES
    resource.setrlimit(resource.RLIMIT_DATA, (allowed, allowed))


def main(name: str, seed: int, first: int, count: int) -> None:
    with tempfile.TemporaryDirectory() as made, tempfile.TemporaryDirectory() as work:
        sample, folder = sample_files.write(name, Path(made)), Path(work)
        bench = folder / "bench.yaml"
        sample_files.write_other(name, sample, bench)
        data, path = sample.read_bytes(), place_for(sample, folder)
        for way in range(3):  # the sample itself, so that every library is loaded
            found = attempt(name, way, data, path, bench, 6.0 * LONGEST)
            if found is not None:
                raise AssertionError(f"{name} unchanged: {found}")
        limit_memory()
        for index in range(first, first + count):
            print(f"at {index}", flush=True)
            found = attempt(name, index, input_of(name, data, seed, index), path, bench)
            if found is not None:
                print(f"found {index}: {' '.join(found.split())}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1], *map(int, sys.argv[2:5]))

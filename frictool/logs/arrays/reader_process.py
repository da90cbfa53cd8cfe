"""Reading of tables with a library in a child process.

On a damaged file, HDF5, Arrow and asammdf may crash, hang, or use all memory.

    parent                                          child: limited memory, no output
    tables(path)  ── open ──▶ the library's tables ──▶ their descriptions
    blocks(...)   ── open ──▶ the library's blocks ──▶ block, block, ... loss, ... end

The child is killed if one answer takes more processor time than a file of this size can need. If
the child crashes, LogError is raised in the parent, with a message of one line.
"""

from __future__ import annotations

import contextlib
import faulthandler
import multiprocessing
import os
import signal
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from frictool.errors import LogError
from frictool.logs.arrays.array_table import find_array
from frictool.logs.raw_table import DataLoss, RowBlock, find

WAIT_S = 8.0  # s, processor time allowed for an answer, plus the time to read the whole file
LOOK_S = 0.5  # s, interval between two checks of the processor time
# longest elapsed time relative to the processor time allowed, since a child may hang without using
# the processor
LONGEST_WAIT = 20.0
SLOWEST = 10e6  # bytes/s of processor time, slowest reading of a file that is not damaged
MEMORY = 700_000_000  # bytes that a child may allocate in addition to those at its start
TEXT = 100  # maximum number of characters of a library's error text in a message


@dataclass(kw_only=True)
class LibraryTable:
    """Table of a file that a library has opened (implements RawTable); a subclass defines `blocks`.

    columns: object from which the subclass reads a column, by the name of the column.
    others: description of each item that is not a column of numbers, by name.
    """

    source: str
    columns: Mapping[str, Any]
    units: Mapping[str, str | None]
    others: Mapping[str, str]
    topic: str = ""
    clock: str | None = None

    def __post_init__(self) -> None:
        self.names = tuple(self.columns)
        self.size = Path(self.source).stat().st_size

    def find(self, wanted: str | int) -> str | None:
        """Return the name of the column `wanted` (name, or number from 1); None if missing."""
        return find(self.names, wanted)

    def line(self, row: int) -> int | None:
        """Return None, because the rows have no line numbers."""
        return None

    def blocks(
        self, wanted: Sequence[str], losses: list[DataLoss] | None = None
    ) -> Iterator[tuple[RowBlock, int]]:
        """Yield blocks of rows (see RawTable.blocks)."""
        raise NotImplementedError


Open = Callable[[Path], Sequence[LibraryTable]]


@dataclass
class GuardedTable:
    """Table whose rows are read in a child process (implements RawTable).

    others: description of each item that is not a column of numbers, by name.
    opened: function that opens the file in the child and returns the tables of the file.
    index: index of this table in the result of `opened`.
    """

    source: str
    topic: str
    names: tuple[str, ...]
    units: Mapping[str, str | None]
    clock: str | None
    size: int
    others: Mapping[str, str]
    opened: Open
    index: int

    def find(self, wanted: str | int) -> str | None:
        """Return the name of the column `wanted` (name, or number from 1); None if missing.

        `TOPIC/NAME` denotes the column NAME if TOPIC is the topic of this table. Raises LogError if
        `wanted` is an item that is not a column of real numbers.
        """
        if (
            isinstance(wanted, str)
            and self.topic
            and wanted.startswith(f"{self.topic}/")
            and wanted not in self.names
        ):
            wanted = wanted.removeprefix(f"{self.topic}/")
        if isinstance(wanted, str) and wanted in self.others and wanted != self.clock:
            raise LogError(
                self.source, f"{wanted!r} is {self.others[wanted]}; allowed: real numbers"
            )
        return find_array(self.names, wanted)

    def blocks(
        self, wanted: Sequence[str], losses: list[DataLoss] | None = None
    ) -> Iterator[tuple[RowBlock, int]]:
        """Yield blocks of rows (see RawTable.blocks).

        If the library fails, LogError is raised if `losses` is None; otherwise a loss is appended
        to `losses`.
        """
        read = 0
        try:
            for kind, *answer in _child(
                Path(self.source),
                _blocks,
                (self.opened, self.index, tuple(wanted), losses is not None),
            ):
                if kind == "loss" and losses is not None:
                    losses.append(answer[0])
                elif kind == "block":
                    block, done = answer
                    read = block.first_row + _rows(block)
                    yield block, done
        except LogError as error:
            if losses is None:
                raise
            losses.append(DataLoss((), f"{error} (after {read} samples)"))

    def line(self, row: int) -> int | None:
        """Return None, because the rows have no line numbers."""
        return None


def open_guarded(path: Path, opened: Open) -> tuple[GuardedTable, ...]:
    """Call `opened(path)` in a child process and return the resulting tables.

    The rows of these tables are read in child processes, too. Raises LogError if the file cannot be
    opened.
    """
    for kind, *answer in _child(path, _tables, (opened,)):
        if kind == "tables":
            return tuple(
                GuardedTable(source=str(path), opened=opened, index=index, **one)
                for index, one in enumerate(answer[0])
            )
    raise LogError(path, "is damaged: its reader found no tables")


def _tables(send: Callable[[Any], None], path: Path, opened: Open) -> None:
    kept = ("topic", "names", "units", "clock", "size", "others")
    send(("tables", [{name: getattr(one, name) for name in kept} for one in opened(path)]))


def _blocks(
    send: Callable[[Any], None],
    path: Path,
    opened: Open,
    index: int,
    wanted: tuple[str, ...],
    salvage: bool,
) -> None:
    losses: list[DataLoss] | None = [] if salvage else None
    for block, done in opened(path)[index].blocks(wanted, losses):
        _send_losses(send, losses)
        send(("block", block, done))
    _send_losses(send, losses)


def _send_losses(send: Callable[[Any], None], losses: list[DataLoss] | None) -> None:
    for loss in losses or ():
        send(("loss", loss))
    if losses:
        losses.clear()


def _child(
    path: Path, work: Callable[..., None], arguments: tuple[Any, ...]
) -> Iterator[tuple[Any, ...]]:
    method = (
        "fork"
        if "fork" in multiprocessing.get_all_start_methods() and sys.platform != "darwin"
        else "spawn"
    )
    context = multiprocessing.get_context(method)
    ours, theirs = context.Pipe(duplex=False)
    # typeshed's base of contexts lacks Process; each context has it
    process = context.Process(target=_run, args=(theirs, path, work, arguments), daemon=True)  # type: ignore[attr-defined]
    with warnings.catch_warnings():
        # Python warns of a fork while threads run; the child does not use these threads
        warnings.simplefilter("ignore", DeprecationWarning)
        process.start()
    theirs.close()
    patience = WAIT_S + path.stat().st_size / SLOWEST
    try:
        while True:
            if not _answers(ours, process.pid, patience):
                raise LogError(
                    path,
                    f"is damaged: its reader did not finish within {patience:.0f} s of processor "
                    "time",
                )
            kind, *answer = ours.recv()
            if kind == "end":
                return
            if kind == "error":
                raise LogError(path, answer[0])
            yield kind, *answer
    except EOFError:
        process.join(WAIT_S)
        raise LogError(
            path, f"is damaged: its reader ended with {_cause(process.exitcode)}"
        ) from None
    finally:
        process.kill()
        process.join()
        ours.close()


def _answers(ours: Connection, pid: int | None, patience: float) -> bool:
    begun = time.monotonic()
    used = _processor_time(pid)
    while not ours.poll(LOOK_S):
        waited = time.monotonic() - begun
        now = _processor_time(pid)
        if (
            waited > LONGEST_WAIT * patience
            or (waited if used is None or now is None else now - used) > patience
        ):
            return ours.poll(0.0)
    return True


def _processor_time(pid: int | None) -> float | None:
    try:
        fields = (
            Path(f"/proc/{pid}/stat")
            .read_text(encoding="utf-8", errors="replace")
            .rpartition(")")[2]
            .split()
        )
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    except (OSError, ValueError, IndexError, AttributeError):
        return None


def _run(
    connection: Connection, path: Path, work: Callable[..., None], arguments: tuple[Any, ...]
) -> None:
    # the handler of the command line would wait for a hanging library
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    _silence()
    _limit_memory()
    try:
        work(connection.send, path, *arguments)
        connection.send(("end",))
    except LogError as error:
        connection.send(("error", str(error).removeprefix(f"{path}: ")))
    except MemoryError:
        connection.send(
            ("error", f"is damaged, or a part of it needs more than {MEMORY // 10**6} MB to read")
        )
    except BrokenPipeError:  # the parent has stopped reading
        pass
    except BaseException as error:  # SystemExit of a library is a failure, too
        text = " ".join(str(error).split())[:TEXT]
        connection.send(
            (
                "error",
                "is cut off, damaged, or of a kind that frictool cannot read: "
                f"{text or type(error).__name__}",
            )
        )


def _silence() -> None:
    faulthandler.disable()
    nothing = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115  # open until the process ends
    sys.stdout = sys.stderr = nothing
    with contextlib.suppress(OSError, ValueError):
        os.dup2(nothing.fileno(), 1)
        os.dup2(nothing.fileno(), 2)
    warnings.simplefilter("ignore")


def _limit_memory() -> None:
    with contextlib.suppress(ImportError, OSError, ValueError, StopIteration):
        import resource

        lines = Path("/proc/self/status").read_text(encoding="ascii", errors="replace").splitlines()
        used = next(int(line.split()[1]) * 1024 for line in lines if line.startswith("VmData:"))
        _, most = resource.getrlimit(resource.RLIMIT_DATA)
        allowed = used + MEMORY if most == resource.RLIM_INFINITY else min(used + MEMORY, most)
        resource.setrlimit(resource.RLIMIT_DATA, (allowed, most))


def _cause(code: int | None) -> str:
    if code is not None and code < 0:
        with contextlib.suppress(ValueError):
            return f"signal {signal.Signals(-code).name}"
    return f"code {code}"


def _rows(block: RowBlock) -> int:
    return (
        block.time_ns.size
        if block.time_ns is not None
        else next((column.size for column in block.columns.values()), 0)
    )

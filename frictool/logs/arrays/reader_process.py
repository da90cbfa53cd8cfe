"""Tables that a library reads, in a process of their own: on a damaged file HDF5, Arrow and asammdf
may crash, hang, or take all memory.

    here                                            child: limited memory, silent
    tables(path)  ── open ──▶ the library's tables ──▶ what they are
    blocks(...)   ── open ──▶ the library's blocks ──▶ block, block, ... loss, ... end

The child is ended if it takes more processor time for an answer than a file of that size can need.
Any crash becomes a message of one line. Processor time does not depend on other programs of the
machine.
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
from typing import Any, Protocol

from frictool.errors import LogError
from frictool.logs.arrays.array_table import find_array
from frictool.logs.table import DataLoss, RawTable, RowBlock

WAIT_S = 8.0  # s of processor time for an answer, in addition to the time to read the whole file
LOOK_S = 0.5  # s between two checks of the processor time
# longest elapsed time, relative to the processor time allowed: a child may wait for ever without
# using the processor
LONGEST_WAIT = 20.0
SLOWEST = 10e6  # bytes/s
MEMORY = 700_000_000  # bytes that a child may take, beside what it starts with
TEXT = 300  # characters of a library's message


class LibraryTable(RawTable, Protocol):
    """A table that also says of what is no column of numbers, by its name, what it is."""

    others: Mapping[str, str]


Open = Callable[[Path], Sequence[LibraryTable]]


@dataclass
class GuardedTable:
    """A table whose rows are read in a child process; `opened` and `index` say which."""

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
        """As `Table.find`; `TOPIC/NAME` asks for a column of this table alone. Raises LogError
        where it is no column of real numbers."""
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
        """As `Table.blocks`. Raises LogError where the library fails, whatever it does; with
        `losses`, that is one of them."""
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
        """None: the file has no lines."""
        return None


def open_guarded(path: Path, opened: Open) -> tuple[GuardedTable, ...]:
    """The tables that `opened(path)` gives, to be read in child processes. Raises LogError where
    they cannot be opened."""
    for kind, *answer in _child(path, _tables, (opened,)):
        if kind == "tables":
            return tuple(
                GuardedTable(source=str(path), opened=opened, index=index, **one)
                for index, one in enumerate(answer[0])
            )
    raise LogError(path, "is damaged: its reader found no tables")


def _tables(send: Callable[[Any], None], path: Path, opened: Open) -> None:
    """In the child: what the tables are."""
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
    """In the child: the rows of one table; a loss before the block that follows it."""
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
    """What `work` sends from a child process. Raises LogError where the child tells of an error,
    dies, or falls silent."""
    method = (
        "fork"
        if "fork" in multiprocessing.get_all_start_methods() and sys.platform != "darwin"
        else "spawn"
    )
    context = multiprocessing.get_context(method)
    ours, theirs = context.Pipe(duplex=False)
    process = context.Process(target=_run, args=(theirs, path, work, arguments), daemon=True)  # type: ignore[attr-defined]  # not of every context
    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore", DeprecationWarning
        )  # forking beside threads: the child starts none of their work anew
        process.start()
    theirs.close()
    patience = WAIT_S + path.stat().st_size / SLOWEST
    try:
        while True:
            if not _answers(ours, process.pid, patience):
                raise LogError(
                    path,
                    f"is damaged: its reader came to no end in {patience:.0f} s of processor time",
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
    """Return whether an answer comes within `patience` s of processor time and LONGEST_WAIT times
    that of elapsed time."""
    begun, used = time.monotonic(), _processor_time(pid)
    while not ours.poll(LOOK_S):
        waited, now = time.monotonic() - begun, _processor_time(pid)
        if (
            waited > LONGEST_WAIT * patience
            or (waited if used is None or now is None else now - used) > patience
        ):
            return ours.poll(0.0)
    return True


def _processor_time(pid: int | None) -> float | None:
    """Return the processor time of a process in s; None on systems other than Linux."""
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
    """The child: works in silence, tells of every failure."""
    signal.signal(
        signal.SIGTERM, signal.SIG_DFL
    )  # the command line's handler waits for a library that hangs
    _silence()
    _limit_memory()
    try:
        work(connection.send, path, *arguments)
        connection.send(("end",))
    except LogError as error:
        connection.send(("error", str(error).removeprefix(f"{path}: ")))
    except MemoryError:
        connection.send(
            ("error", f"is damaged, or has pieces that need more than {MEMORY // 10**6} MB to read")
        )
    except BrokenPipeError:  # who reads has seen enough
        pass
    except BaseException as error:  # a library's exit is as much a failure as what it raises
        text = " ".join(str(error).split())[:TEXT]
        connection.send(
            (
                "error",
                f"is cut off, damaged, or of a kind that is not read: {text or type(error).__name__}",
            )
        )


def _silence() -> None:
    """What a library has to say of a file is not for the user's terminal."""
    faulthandler.disable()
    nothing = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115  # open as long as the process
    sys.stdout = sys.stderr = nothing
    with contextlib.suppress(OSError, ValueError):
        os.dup2(nothing.fileno(), 1)
        os.dup2(nothing.fileno(), 2)
    warnings.simplefilter("ignore")


def _limit_memory() -> None:
    """Where the system can tell what is used already and can limit what is added: Linux."""
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

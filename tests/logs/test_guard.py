"""A reader in a process of its own: whatever becomes of it is one line, or a loss."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from frictool.errors import LogError
from frictool.logs.arrays import reader_process
from frictool.logs.formats import tables_of
from frictool.logs.raw_table import DataLoss, RowBlock
from tests.support.example_logs import GOLDEN


@dataclass
class Failing:
    """One good block, then what the test wants."""

    source: str
    end: Callable[[], None]
    topic: str = ""
    names: tuple[str, ...] = ("x",)
    units: dict[str, str | None] = field(default_factory=lambda: {"x": "A"})
    others: dict[str, str] = field(default_factory=dict)
    clock: str | None = None
    size: int = 100

    def find(self, wanted: str | int) -> str | None:
        raise AssertionError("asked in the parent")

    def line(self, row: int) -> int | None:
        raise AssertionError("asked in the parent")

    def blocks(
        self, wanted: Sequence[str], losses: list[DataLoss] | None = None
    ) -> Iterator[tuple[RowBlock, int]]:
        yield RowBlock(0, {"x": np.arange(3.0)}), 50
        if losses is not None:
            losses.append(DataLoss(("x",), "one is missing", samples=1))
        self.end()
        yield RowBlock(4, {"x": np.arange(2.0)}), 100


@pytest.fixture
def path(tmp_path: Path) -> Path:
    file = tmp_path / "x.bin"
    file.write_bytes(b"x")
    return file


def busy() -> None:
    end = time.monotonic() + 60.0
    while time.monotonic() < end:
        pass


def table(path: Path, end: Callable[[], None]) -> reader_process.GuardedTable:
    (found,) = reader_process.open_guarded(path, lambda one: (Failing(str(one), end),))
    return found


@pytest.fixture(autouse=True)
def little_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reader_process, "MEMORY", 90_000_000)


def test_blocks_and_losses_come_in_their_order(path: Path):
    losses: list[DataLoss] = []
    seen = [
        (block.first_row, len(losses))
        for block, _ in table(path, lambda: None).blocks(["x"], losses)
    ]
    assert seen == [(0, 0), (4, 1)]
    assert losses == [DataLoss(("x",), "one is missing", samples=1)]


def die() -> None:
    os.kill(os.getpid(), signal.SIGSEGV)


def take_all_memory() -> None:
    parts = []
    while True:
        parts.append(np.ones(1_000_000))


def fail() -> None:
    raise KeyError("no such\nthing")


def speak() -> None:
    print("noise")
    print("noise", file=sys.stderr)
    os.write(2, b"noise")
    raise LogError("x", "a clear line")


@pytest.mark.parametrize(
    ("end", "message"),
    [
        (die, "is damaged: its reader ended with signal SIGSEGV"),
        (take_all_memory, "needs more than 90 MB"),
        (fail, "is cut off, damaged, or of a kind that frictool cannot read: .*no such.*thing"),
        (lambda: os._exit(3), "is damaged: its reader ended with code 3"),
        (speak, "a clear line"),
    ],
)
def test_whatever_becomes_of_the_reader_is_one_line(
    path: Path, end: Callable[[], None], message: str, capfd: pytest.CaptureFixture[str]
):
    with pytest.raises(LogError, match=message) as caught:
        list(table(path, end).blocks(["x"]))
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)
    losses: list[DataLoss] = []
    assert [block.first_row for block, _ in table(path, end).blocks(["x"], losses)] == [0]
    assert losses[-1].channels == ()
    assert capfd.readouterr() == ("", "")


def test_a_reader_that_hangs_is_ended(path: Path, monkeypatch: pytest.MonkeyPatch):
    """Busy or waiting: the one by its processor time, the other by the clock."""
    monkeypatch.setattr(reader_process, "WAIT_S", 0.2)
    monkeypatch.setattr(reader_process, "LONGEST_WAIT", 5.0)
    for end in (lambda: time.sleep(60), busy):
        start = time.monotonic()
        with pytest.raises(LogError, match="its reader did not finish"):
            list(table(path, end).blocks(["x"]))
        assert time.monotonic() - start < 30


@pytest.mark.skipif(
    reader_process._processor_time(os.getpid()) is None,
    reason="the system does not tell processor times",
)
def test_a_reader_that_has_to_wait_is_not_ended(path: Path, monkeypatch: pytest.MonkeyPatch):
    """A machine with other work gives it little processor time: the clock alone does not end it."""
    monkeypatch.setattr(reader_process, "WAIT_S", 0.2)
    assert [block.first_row for block, _ in table(path, lambda: time.sleep(1.2)).blocks(["x"])] == [
        0,
        4,
    ]


def test_who_stops_reading_leaves_no_process(path: Path):
    import multiprocessing

    blocks = table(path, lambda: None).blocks(["x"])
    next(blocks)
    blocks.close()
    assert not multiprocessing.active_children()


@pytest.mark.parametrize(
    ("name", "library", "extra"),
    [
        ("v4.mf4", "asammdf", "mdf"),
        ("stamps.parquet", "pyarrow", "parquet"),
        ("v73.mat", "h5py", "mat73"),
    ],
)
def test_a_missing_library_is_named_with_its_extra(
    name: str, library: str, extra: str, monkeypatch: pytest.MonkeyPatch
):
    for module in (library, f"{library}.parquet"):
        monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(
        LogError, match=rf"{name}: needs {library}.*pip install 'frictool\[{extra}\]'"
    ):
        tables_of(GOLDEN / name)

"""A log format that is added by the recipe alone is read and written by the commands."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from frictool.logs.canonical.mcap_format import write_mcap
from tests.support.example_logs import golden_log
from tests.support.recipes import follow, frictool_each


@pytest.fixture(scope="module")
def overlay(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("format")
    follow("A log format", folder)
    with (folder / "run.mcap").open("wb") as stream:
        write_mcap(golden_log(), stream)
    return folder


def test_convert_writes_the_format_and_info_reads_it(overlay: Path) -> None:
    target, axis = overlay / "run.columns", golden_log().main
    convert = ["convert", overlay / "run.mcap"]
    done, told, chosen = frictool_each(
        overlay,
        [*convert, "--stream", "/axis", "-o", target],
        ["info", target],
        [*convert, "--to", "columns", "-o", "-"],
    )
    assert done.returncode == 0, done.stderr
    header, _, data = target.read_bytes().partition(b"\n")
    rows = np.frombuffer(data).reshape(axis.time.size, -1)
    units = json.loads(header.removeprefix(b"COLUMNS "))
    assert [*units] == ["time", *axis.signals]
    for k, name in enumerate(axis.signals, start=1):
        assert rows[:, k].tobytes() == axis.signals[name].tobytes()
    assert told.returncode == 0, told.stderr
    assert all(name in told.stdout for name in axis.signals)
    assert "a columns file can contain only one" in chosen.stderr


def test_help_and_messages_list_the_format(overlay: Path) -> None:
    binary, damaged = overlay / "binary.dat", overlay / "damaged.columns"
    binary.write_bytes(bytes(range(256)))
    damaged.write_bytes(b'COLUMNS {"t": "s"}\n1234567')
    shown, *refused = frictool_each(
        overlay,
        ["convert", "--help"],
        ["convert", overlay / "run.mcap", "-o", overlay / "run.pdf"],
        ["info", binary],
        ["info", damaged],
    )
    assert "columns|" in shown.stdout
    assert [one.returncode for one in refused] == [2, 3, 3]
    for one, words in zip(
        refused,
        (
            ".columns, ",
            ", columns of doubles, text with columns (CSV)",
            "its rows do not fit its first line",
        ),
        strict=True,
    ):
        assert words in one.stderr

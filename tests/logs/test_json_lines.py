"""JSON lines: numbers by their path, times from dates, and damage line by line."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from frictool.errors import LogError
from frictool.logs.formats import format_of, tables_of
from frictool.logs.raw_table import DataLoss, RawTable


def table_of(folder: Path, text: str) -> RawTable:
    path = folder / "log.jsonl"
    path.write_text(text)
    assert format_of(path).name == "jsonl"
    (table,) = tables_of(path)
    return table


def column(table: RawTable, name: str, losses: list[DataLoss] | None = None) -> list[float]:
    return [float(x) for block, _ in table.blocks([name], losses) for x in block.columns[name]]


def test_nested_numbers_are_columns(tmp_path: Path) -> None:
    lines = [{"t": k / 100, "axis": {"pos": [k, -k], "on": True}, "note": "x"} for k in range(5)]
    table = table_of(tmp_path, "".join(json.dumps(line) + "\n" for line in lines))
    assert table.names == ("t", "axis.pos[0]", "axis.pos[1]", "axis.on")
    assert column(table, "axis.pos[1]") == [0, -1, -2, -3, -4]
    assert table.clock is None


def test_lines_of_other_messages_are_no_rows(tmp_path: Path) -> None:
    text = '{"t": 0, "pos": 1}\n\n{"event": 7}\n{"t": 1, "pos": 2}\n{"t": 2}\n'
    table = table_of(tmp_path, text)
    assert column(table, "pos") == [1, 2]
    (block,) = [block for block, _ in table.blocks(["t", "pos"])]
    assert block.columns["t"].tolist() == [0, 1, 2]
    assert np.isnan(block.columns["pos"][2])


def test_a_date_gives_the_times(tmp_path: Path) -> None:
    text = "".join(f'{{"at": "2026-01-31T23:59:59.{k:03d}Z", "pos": {k}}}\n' for k in (0, 250, 500))
    table = table_of(tmp_path, text)
    assert table.clock == "at"
    (block,) = [block for block, _ in table.blocks(["pos"])]
    assert np.asarray(block.time_ns).tolist() == [
        1_769_903_999_000_000_000 + k * 1_000_000 for k in (0, 250, 500)
    ]
    damaged = table_of(tmp_path, text + '{"pos": 3}\n{"at": "2026-02-30T00:00:00", "pos": 3}\n')
    losses: list[DataLoss] = []
    assert column(damaged, "pos", losses) == [0, 250, 500]
    assert [loss.reason.partition(":")[0] for loss in losses] == ["line 4", "line 5"]


def test_a_line_of_another_message_needs_no_date(tmp_path: Path) -> None:
    rows = "".join(f'{{"at": "2026-01-31T10:00:0{k}Z", "pos": {k}}}\n' for k in range(3))
    table = table_of(tmp_path, '{"event": "start"}\n' + rows)
    assert table.clock == "at"
    assert column(table, "pos") == [0, 1, 2]


def test_a_damaged_line_is_named_or_lost(tmp_path: Path) -> None:
    for lines in (300, 4):  # beyond and among the lines that name the columns
        table = table_of(tmp_path, "\n" + '{"pos": 1}\n{"pos": 2}\n' * (lines // 2) + '{"pos": 1')
        with pytest.raises(LogError, match=rf":{lines + 2}: is not JSON.*ingest --salvage"):
            column(table, "pos")
        losses: list[DataLoss] = []
        assert len(column(table, "pos", losses)) == lines
        assert [loss.reason.partition(":")[0] for loss in losses] == [f"line {lines + 2}"]


@pytest.mark.parametrize(
    "text",
    [
        '[{"pos": 1}]\n',
        '{"entries":\n[{"pos": 1}]}\n',
        '{"kp": 3, "entries": [{"pos": 1}, {"pos": 2}], "more": [{"pos": 1}, {"pos": 2}]}\n',
    ],
)
def test_one_document_is_refused_with_a_command(text: str, tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"one JSON document; write one object per line, .* jq -c"):
        table_of(tmp_path, text)


def test_a_byte_order_mark_is_left_out(tmp_path: Path) -> None:
    table = table_of(tmp_path, '\ufeff{"pos": 1}\n{"pos": 2}\n')
    assert column(table, "pos") == [1, 2]


def test_an_object_without_numbers_is_refused(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="has no number in its first 200 lines"):
        table_of(tmp_path, '{"a": "b"}\n')


@pytest.mark.parametrize("indent", [None, 2])
def test_a_document_with_one_list_of_samples_is_a_table(indent: int | None, tmp_path: Path) -> None:
    """Numbers outside the list are constant columns; a sample's own number takes precedence."""
    samples = [{"t": 0.01 * k, "pos": 0.5 * k, "on": k > 1} for k in range(4)]
    document = {"kp": 12, "motor": "servo", "pos": 9.0, "entries": samples, "none": []}
    table = table_of(tmp_path, json.dumps(document, indent=indent))
    assert set(table.names) == {"kp", "pos", "t", "on"}
    assert column(table, "pos") == [0.0, 0.5, 1.0, 1.5]
    assert column(table, "on") == [0.0, 0.0, 1.0, 1.0]
    assert column(table, "kp") == [12.0] * 4

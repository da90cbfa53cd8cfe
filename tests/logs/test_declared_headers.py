"""Text files whose instrument declares its header: LabVIEW, TwinCAT Scope, Tektronix; dates with
the year last; samples beyond the range of a PicoScope."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from frictool.documents.bench import Layout
from frictool.errors import LogError
from frictool.logs.channels.column_guess import read_start
from frictool.logs.raw_table import DataLoss
from frictool.logs.text.csv_format import CsvTable
from tests.support.logger_headers import twincat

LABVIEW = (
    "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t{mark}\n"
    "X_Columns\t{columns}\nTime_Pref\tAbsolute\nDate\t2026/01/31\nTime\t10:00:00{mark}5\n"
    "***End_of_Header***\t\n\t\nChannels\t2\t\t\n"
)


def labview(units: str, steps: str, header: str, rows: str, columns: str = "No") -> str:
    return (
        LABVIEW.format(mark=",", columns=columns)
        + f"Samples\t3\t3\t\nY_Unit_Label\t{units}\nX_Dimension\tTime\tTime\t\nX0\t0,5\t0,5\t\n"
        + f"Delta_X\t{steps}\n***End_of_Header***\t\t\t\n{header}\n{rows}"
    )


def opened(folder: Path, text: str, layout: Layout | None = None) -> CsvTable:
    path = folder / "log.txt"
    path.write_text(text)
    return CsvTable(path, layout or Layout())


def column(table: CsvTable, name: str, losses: list[DataLoss] | None = None) -> list[float]:
    return [float(x) for block, _ in table.blocks([name], losses) for x in block.columns[name]]


def times(table: CsvTable, name: str) -> list[int]:
    return [
        int(ns) for block, _ in table.blocks([name]) for ns in np.asarray(block.time_ns).tolist()
    ]


def test_labview_without_times_is_sampled_at_delta_x(tmp_path: Path) -> None:
    text = labview(
        "Newtons\tmm\t",
        "0,002\t0,002\t",
        "X_Value\tForce\tTravel\tComment",
        "\t1,5\t2,5\n\t1,75\t2,75\tpause\n\t2,0\t3,0\n",
    )
    table = opened(tmp_path, text)
    assert table.names == ("X_Value", "Force", "Travel")
    assert table.units == {"X_Value": "s", "Force": "N", "Travel": "mm"}
    assert column(table, "Force") == [1.5, 1.75, 2.0]
    assert times(table, "Travel") == [500_000_000, 502_000_000, 504_000_000]


def test_labview_with_a_time_column_per_channel(tmp_path: Path) -> None:
    text = labview(
        "V\t\tA\t",
        "0,001\t\t0,001\t",
        "X_Value\tu\tX_Value\ti\tComment",
        "0,0\t1,0\t0,0\t5,0\n0,001\t2,0\t0,001\t6,0\n",
        "Multi",
    )
    table = opened(tmp_path, text)
    assert dict(table.units) == {
        "X_Value (column 1)": "s",
        "u": "V",
        "X_Value (column 3)": "s",
        "i": "A",
    }
    assert column(table, "i") == [5.0, 6.0]


@pytest.mark.parametrize(
    ("steps", "rows", "reason"),
    [
        ("0,002\t0,001\t", "\t1,5\t2,5\n", "no common Delta_X in s; write layout.period_s"),
        ("0,002\t0,002\t", "", "no samples after its second LabVIEW header; .*layout.first_line"),
    ],
)
def test_labview_that_does_not_say_its_times_is_refused(
    steps: str, rows: str, reason: str, tmp_path: Path
) -> None:
    with pytest.raises(LogError, match=reason):
        opened(tmp_path, labview("V\tA\t", steps, "X_Value\tu\ti\tComment", rows))


def test_a_second_segment_of_labview_is_refused_with_its_line(tmp_path: Path) -> None:
    rows = "\t1,5\t2,5\n" * 3 + "\nChannels\t2\t\t\n" + "\t1,5\t2,5\n" * 3
    text = labview("V\tA\t", "0,002\t0,002\t", "X_Value\tu\ti\tComment", rows)
    table = opened(tmp_path, text)
    line = text[: text.rindex("Channels")].count("\n") + 1
    with pytest.raises(LogError, match=rf":{line}: "):
        column(table, "i")


def test_twincat_ends_with_its_trailer(tmp_path: Path) -> None:
    rows = len(column(opened(tmp_path, twincat(unit="deg")), "fActPosition"))
    for end in ("EOF", "EOF\n"):
        table = opened(tmp_path, twincat(unit="deg") + end)
        losses: list[DataLoss] = []
        assert len(column(table, "fActPosition", losses)) == rows
        assert not losses
        assert column(table, "fActPosition") == column(table, "fActPosition", losses)
    assert table.units == {
        "Time": "ms",
        "fActPosition": "deg",
        "Time (column 3)": "ms",
        "fActTorque": "deg",
    }


def test_an_index_instead_of_times_has_no_unit(tmp_path: Path) -> None:
    text = twincat().replace("SampleTime[ms]\t1", "SampleTime[ms]\t0,25")
    assert opened(tmp_path, text).units["Time"] is None


def test_twincat_with_names_only(tmp_path: Path) -> None:
    text = (
        "Name,Scope\nFile,C:\\s.svdx\nStarttime of export,133000000000000000\n"
        "Endtime of export,133000000010000000\n\nName,a,b\n0,1.5,3\n2,1.75,4\n4,2,5\n"
    )
    table = opened(tmp_path, text)
    assert table.units == {"Time": "ms", "a": None, "b": None}
    assert column(table, "a") == [1.5, 1.75, 2.0]


def test_channels_of_several_sample_times_are_refused(tmp_path: Path) -> None:
    text = (
        "Name,Scope\nFile,C:\\s.svdx\nStarttime of export,133000000000000000\n\n"
        "Name,a,Name,b\n0,1.5,0,3\n2,1.75,4,4\n4,2,8,5\n"
    )
    with pytest.raises(LogError, match=r"different times \(2, 4 in one row\); export the channels"):
        opened(tmp_path, text)


def test_tektronix_names_the_columns_beside_its_metadata(tmp_path: Path) -> None:
    head = [
        "Record Length,4,Points",
        "Sample Interval,1e-3,s",
        "Source,CH2,",
        "Vertical Units,V,",
        "Horizontal Units,s,",
        *[",,"] * 20,
    ]
    text = "".join(f"{left},{k / 1000:.3f},{k % 7:.2f},\n" for k, left in enumerate(head))
    table = opened(tmp_path, text)
    assert (table.units["Time"], table.units["CH2"]) == ("s", "V")
    assert column(table, "CH2") == [k % 7 for k in range(len(head))]


def test_the_metadata_of_a_tektronix_are_no_columns(tmp_path: Path) -> None:
    """As a TDS2000 writes it, with three rows without metadata."""
    head = ["Record Length,2.5e3,", "Sample Interval,4e-6,", "Trigger Point,1.25e3,", *[",,"] * 3]
    head += ["Source,CH1,", "Vertical Units,V,", "Horizontal Units,s,", "Pt Fmt,Y,", *[",,"] * 20]
    text = "".join(f"{left},  {4e-6 * k:+.12f},  {k % 7:.5f},\n" for k, left in enumerate(head))
    (read,) = read_start([opened(tmp_path, text)])
    assert read.units == {"Time": "s", "CH1": "V"}
    assert read.columns["CH1"].tolist() == [k % 7 for k in range(len(head))]


def test_labview_with_one_header_is_read_with_its_layout(tmp_path: Path) -> None:
    text = (
        "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t,\n***End_of_Header***\t\n\t\n"
        "0,0\t1,5\n0,1\t1,75\n0,2\t2,0\n"
    )
    with pytest.raises(LogError, match=r"write layout\.header_line and layout\.first_line"):
        opened(tmp_path, text)
    table = opened(tmp_path, text, Layout(header_line=0, first_line=6))
    assert column(table, "2") == [1.5, 1.75, 2.0]


DATES = {
    "31.01.2026 23:59:59.5": 1_769_903_999_500_000_000,
    "31/01/2026 23:59:59.5": 1_769_903_999_500_000_000,
    "01/31/2026 11:59:59.5 PM": 1_769_903_999_500_000_000,
    "2026/1/31 23:59:59.5": 1_769_903_999_500_000_000,
}


@pytest.mark.parametrize("date", DATES)
def test_a_date_with_the_year_last_is_read(date: str, tmp_path: Path) -> None:
    table = opened(tmp_path, f"when;x\n{date};1\n")
    assert table.clock == "when"
    assert times(table, "x") == [DATES[date]]


def test_the_order_of_a_date_is_asked_where_the_file_does_not_show_it(tmp_path: Path) -> None:
    text = "when,x\n03/04/2026 12:00:00,1\n03/04/2026 12:00:01,2\n"
    with pytest.raises(LogError, match=r"layout\.dates: day-first or month-first"):
        opened(tmp_path, text)
    april, march = (
        times(opened(tmp_path, text, Layout(dates=order)), "x")[0]
        for order in ("day-first", "month-first")
    )
    assert (april - march) / 86_400e9 == 30  # 4 March to 3 April
    with pytest.raises(LogError, match=r":4: .*found '13/04/2026 12:00:02'"):
        times(opened(tmp_path, text + "13/04/2026 12:00:02,3\n", Layout(dates="month-first")), "x")


def test_a_sample_beyond_the_range_is_saturation(tmp_path: Path) -> None:
    text = "Time,Channel A\n(ms),(V)\n\n0.0,1.0\n0.1,\u221e\n0.2,-\u221e\n0.3,2.0\n"
    table = opened(tmp_path, text)
    assert table.units == {"Time": "ms", "Channel A": "V"}
    with pytest.raises(LogError, match=r":5: .*out of range\); allowed: .*larger range"):
        column(table, "Channel A")
    values = column(table, "Channel A", [])
    assert [np.isfinite(value) for value in values] == [True, False, False, True]

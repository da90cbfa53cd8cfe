"""Small files of an axis as loggers and instruments write them in text.

The headers follow the makers' descriptions of their formats; position, current and times are those
of logger_files.py.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence

from tests.support.logger_files import CURRENT, FRAME, PERIOD_MS, POSITION, ROWS, payloads

CRLF = "\r\n"
SAMPLES = list(zip(range(ROWS), POSITION.tolist(), CURRENT.tolist(), strict=True))


def _lines(lines: Sequence[str]) -> str:
    return "".join(line + CRLF for line in lines)


def twincat() -> str:
    """TwinCAT Scope, German settings: keys in pairs with values, times in ms, trailer."""
    keys = {
        "Name": ("encoder", "current"),
        "SymbolComment": ("", ""),
        "Data-Type": ("INT16", "LREAL"),
        "SampleTime[ms]": (str(PERIOD_MS), str(PERIOD_MS)),
        "SymbolBased": ("True", "True"),
        "SymbolName": ("MAIN.encoder", "MAIN.current"),
        "NetID": ("5.23.9.1.1.1", "5.23.9.1.1.1"),
        "Port": ("851", "851"),
        "Unit": ("(None)", "A"),
        "ScaleFactor": ("1", "1"),
    }
    head = [
        "Name\tAxis",
        "File\tC:\\axis.tcscopex",
        "Starttime of export\t132956925843760000\tMontag, 2. Mai 2022\t10:09:44.376",
        "",
        *("\t".join(f"{key}\t{cell}" for cell in cells) for key, cells in keys.items()),
        "",
    ]
    rows = [f"{PERIOD_MS * k}\t{n:g}\t{PERIOD_MS * k}\t{i:.2f}" for k, n, i in SAMPLES]
    return _lines([*head, *(row.replace(".", ",") for row in rows), "EOF"])


def siemens() -> str:
    """Trace of a Siemens technology object: names of tags, semicolons, times in ms."""
    rows = [f"{PERIOD_MS * k};{n:g};{i:.2f}" for k, n, i in SAMPLES]
    return _lines(["Time;Drive_1.encoder;Drive_1.current", *rows])


def tektronix() -> str:
    """Oscilloscope of the TDS series: the metadata is in the columns before the samples."""
    head = [
        "Record Length,40,Points",
        f"Sample Interval,{PERIOD_MS / 1000:g},s",
        "Trigger Point,0,Samples",
        ",,",
        "Source,CH1,",
        "Vertical Units,A,",
        "Vertical Scale,0.5,",
        "Horizontal Units,s,",
        "Pt Fmt,Y,",
    ]
    head += [",,"] * (ROWS - len(head))
    return _lines(
        [
            f"{left},{PERIOD_MS * k / 1000:.6f},{i:.2f},"
            for left, (k, _, i) in zip(head, SAMPLES, strict=True)
        ]
    )


def rigol() -> str:
    """Oscilloscope of Rigol: units below the names, start and increment beside the first rows."""
    rows = [f"{k},{n:.2e},{i:.2e},," for k, n, i in SAMPLES]
    head = ["X,CH1,CH2,Start,Increment", f"Sequence,Volt,Ampere,0.0,{PERIOD_MS / 1000:.6e}"]
    return _lines([*head, *rows])


def picoscope() -> str:
    """PicoScope: units in parentheses, then an empty line."""
    rows = [f"{PERIOD_MS * k:.8f},{n:.5f},{1000 * i:.5f}" for k, n, i in SAMPLES]
    return _lines(["Time,encoder,current", "(ms),(V),(mA)", "", *rows])


def labview() -> str:
    """LabVIEW measurement with decimal comma and without a time column."""
    step = f"{PERIOD_MS / 1000:.6f}"
    head = [
        "LabVIEW Measurement\t",
        "Writer_Version\t2",
        "Reader_Version\t2",
        "Separator\tTab",
        "Decimal_Separator\t,",
        "Multi_Headings\tNo",
        "X_Columns\tNo",
        "Time_Pref\tRelative",
        "Date\t2026/01/31",
        "Time\t10:00:00,5",
        "***End_of_Header***\t",
        "",
        "Channels\t2\t\t",
        f"Samples\t{ROWS}\t{ROWS}\t",
        "Date\t2026/01/31\t2026/01/31\t",
        "Y_Unit_Label\tmm\tAmperes\t",
        "X_Dimension\tTime\tTime\t",
        "X0\t0,0\t0,0\t",
        f"Delta_X\t{step}\t{step}\t",
        "***End_of_Header***\t\t\t",
        "X_Value\tencoder\tcurrent\tComment",
    ]
    rows = [f"\t{n:.6f}\t{i:.6f}" + ("\tstart" if k == 0 else "") for k, n, i in SAMPLES]
    return _lines([row.replace(".", ",") for row in (*head, *rows)])


def pcan() -> str:
    """PCAN-Trace, version 1.1: times in ms."""
    rows = [
        f"{k + 1:6d})  {PERIOD_MS * k:10.1f}  Rx         {FRAME:04X}  {len(data)}  {data.hex(' ')} "
        for k, data in enumerate(payloads())
    ]
    head = [
        ";$FILEVERSION=1.1",
        ";$STARTTIME=44543.6028595139",
        ";",
        ";   C:\\axis.trc",
        ";",
        ";---+--   ----+----  --+--  ----+---  +  -+ -- -- -- -- -- -- --",
    ]
    return _lines([*head, *rows])


def json_lines() -> str:
    """One object per line, with the time as a date, and a line of another kind."""
    lines = [
        json.dumps(
            {
                "at": f"2026-01-31T10:00:00.{PERIOD_MS * k:03d}Z",
                "axis": {"encoder": n, "current": i},
                "state": "run",
            }
        )
        for k, n, i in SAMPLES
    ]
    return "\n".join(['{"event": "start"}', *lines]) + "\n"


TEXTS: dict[str, Callable[[], str]] = {
    "twincat.txt": twincat,
    "siemens.csv": siemens,
    "tektronix.csv": tektronix,
    "rigol.csv": rigol,
    "picoscope.csv": picoscope,
    "labview.lvm": labview,
    "pcan.trc": pcan,
    "axis.jsonl": json_lines,
}

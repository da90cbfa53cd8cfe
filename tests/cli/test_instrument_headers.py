"""Headers of instruments and drives, written after their formats: what `ingest --guess` takes from
them, what it asks for, and that nothing else is guessed."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from studies.command_line import run
from tests.support.command_line import refused

K = range(60)
ASKED = "?"


def sine(k: int, size: float = 1.0) -> str:
    return f"{size * np.sin(k / 9):.5f}"


def rows(cells: Callable[[int], list[str]], mark: str = ",") -> str:
    return "".join(mark.join(cells(k)) + "\n" for k in K)


def counts(k: int) -> str:
    return str(round(4000 * float(np.sin(k / 9))))


Columns = dict[str, tuple[str, str]]
# name -> text, channels, sample period in s
HEADERS: dict[str, tuple[str, Columns, float | None]] = {
    "hantek": (
        "nr,time,ch1,ch2\n" + rows(lambda k: [str(k), f"{k * 2e-5:g}", sine(k), sine(k, 2)]),
        {"time": ("time", "s")},
        2e-5,
    ),
    "saleae": (
        "Time [s],Channel 0,Channel 1\n"
        + rows(lambda k: [f"{k * 1e-4:.7f}", str(k % 2), str(k // 2 % 2)]),
        {"time": ("Time", "s")},
        1e-4,
    ),
    "siglent": (
        "Record Length,Analog:60\nSample Interval,0.0001\nVertical Units,V\nHorizontal Units,s\n"
        "Model Number,SDS\nSource,CH1\nSecond,Volt\n"
        + rows(lambda k: [f"{k * 1e-4:.5f}", sine(k)]),
        {"voltage": (ASKED, "V")},
        1e-4,
    ),
    "keysight": (
        "x-axis,1,2\nsecond,Volt,Volt\n" + rows(lambda k: [f"{k * 1e-4:.5E}", sine(k), sine(k, 2)]),
        {"time": ("x-axis", "s"), "voltage": (ASKED, "V")},
        1e-4,
    ),
    "lecroy": (
        "LECROYWS424,1,Waveform\nSegments,1,SegmentSize,60\nSegment,TrigTime,TimeSinceSegment1\n"
        "#1,14-May-2019 13:29:30,0\nTime,Ampl\n" + rows(lambda k: [f"{k * 1e-4:.5f}", sine(k)]),
        {"time": ("Time", "s")},
        1e-4,
    ),
    "tektronix dpo": (
        "Model,MSO4034\nSample Interval,1e-4,\nProbe Attenuation,10,10\nVertical Units,V,V\n\n"
        "TIME,CH1,CH2\n" + rows(lambda k: [f"{k * 1e-4:.5e}", sine(k), sine(k, 2)]),
        {},
        1e-4,
    ),
    "picoscope": (
        "Time,Channel A,Channel B\n(ms),(V),(mV)\n\n"
        + rows(lambda k: [f"{k * 0.1:.8f}", sine(k), sine(k, 200)]),
        {"time": ("Time", "ms"), "voltage": (ASKED, "V")},
        1e-4,
    ),
    "opensim": (
        "motion\nversion=1\nnRows=60\nnColumns=3\ninDegrees=yes\nendheader\n"
        "time\tknee_angle\thip_angle\n"
        + rows(lambda k: [f"{k * 0.01:.3f}", sine(k, 30), sine(k, 20)], "\t"),
        {"time": ("time", "s"), "position": (ASKED, ASKED)},
        0.01,
    ),
    "betaflight": (
        '"Product","Blackbox"\n"Data version",2\n"loopIteration","time","axisP[0]","motor[0]"\n'
        + rows(lambda k: [str(8 * k), str(30_000 + 500 * k), sine(k, 9), str(1000 + k)]),
        {"time": ("time", ASKED)},
        None,
    ),
    "codesys": (
        "time [us];PLC_PRG.fPos;PLC_PRG.fVel\n"
        + rows(lambda k: [str(1000 * k), sine(k, 90), sine(k, 3)], ";"),
        {
            "time": ("time", "us"),
            "position": ("PLC_PRG.fPos", ASKED),
            "velocity": ("PLC_PRG.fVel", ASKED),
        },
        1e-3,
    ),
    "elmo": (
        "Time (s),Position Actual Value [cnt],Active Current [A],Velocity [cnt/sec]\n"
        + rows(lambda k: [f"{k * 1e-3:.4f}", counts(k), sine(k, 2), sine(k, 900)]),
        {
            "time": ("Time", "s"),
            "position": ("Position Actual Value", "count"),
            "current": ("Active Current", "A"),
        },
        1e-3,
    ),
    "maxon": (
        "Time [ms];Position actual value [inc];Current actual value averaged [mA];"
        "Velocity actual value averaged [rpm]\n"
        + rows(lambda k: [str(k), counts(k), sine(k, 900), sine(k, 50)], ";"),
        {
            "time": ("Time", "ms"),
            "position": ("Position actual value", "count"),
            "velocity": ("Velocity actual value averaged", "rpm"),
            "current": ("Current actual value averaged", "mA"),
        },
        1e-3,
    ),
    "kollmorgen": (
        "Recording\nIL.CMD (A),IL.FB (A),VL.FB (rpm),PL.FB (deg)\n"
        + rows(lambda k: [sine(k), sine(k), sine(k, 30), sine(k, 90)]),
        {"position": ("PL.FB", "deg"), "velocity": ("VL.FB", "rpm"), "current": ("IL.FB", "A")},
        None,
    ),
    "catman": (
        "HBM_CATMAN_DATAFILE_5\n60 values\n2 channels\nTime\tForce\ns\tN\n"
        + rows(lambda k: [f"{k * 0.01:.3f}", sine(k, 30)], "\t"),
        {"time": ("Time", "s")},
        0.01,
    ),
    "instron": (
        "Specimen label,1\n\nTime,Extension,Load\n(s),(mm),(N)\n"
        + rows(lambda k: [f'"{k * 0.1:.3f}"', f'"{k * 0.01:.4f}"', f'"{sine(k, 30)}"']),
        {"time": ("Time", "s")},
        0.1,
    ),
    "excel": (
        "sep=;\nDatum;Winkel [°];Strom [A]\n"
        + rows(
            lambda k: [
                f"31.01.2026 12:00:00,{k:03d}",
                sine(k, 90).replace(".", ","),
                sine(k).replace(".", ","),
            ],
            ";",
        ),
        {"position": ("Winkel", "deg"), "current": ("Strom", "A")},
        1e-3,
    ),
    "serial": (
        "ms,counts,pwm\n" + rows(lambda k: [str(10 * k), counts(k), str(k % 255)]),
        {"position": ("counts", "count")},
        None,
    ),
}


@pytest.mark.parametrize("name", HEADERS)
def test_a_header_gives_what_it_says_and_no_more(name: str, tmp_path: Path) -> None:
    text, columns, period = HEADERS[name]
    log = tmp_path / "log.csv"
    log.write_text(text)
    result = run(
        "ingest", "--guess", log, "--axis", "rotary", "-o", tmp_path / "bench.yaml", "--json"
    )
    assert result.code == 0, result.stderr
    facts = json.loads(result.stdout)
    assert {channel: tuple(column) for channel, column in facts["columns"].items()} == columns
    asked = {channel for channel, column in columns.items() if ASKED in column}
    assert set(facts["questions"]) == asked
    assert facts["sample_period_s"] == (None if period is None else pytest.approx(period))


def test_labels_in_the_cells_are_refused_with_what_to_do(tmp_path: Path) -> None:
    log = tmp_path / "log.txt"
    log.write_text(rows(lambda k: [f"angle:{sine(k)}", f"current:{sine(k)}"], "\t"))
    refused(
        run("ingest", "--guess", log, "--axis", "rotary", "-o", tmp_path / "bench.yaml"),
        3,
        "has no row of numbers",
        "--layout first_line=VALUE",
    )

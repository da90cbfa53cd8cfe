"""Small files of an axis as loggers write them in binary: TDMS, ULog, CAN logs with their DBC."""

from __future__ import annotations

import struct
import warnings
from pathlib import Path

import numpy as np

ROWS = 40
PERIOD_MS = 2
POSITION = np.rint(20.0 * np.sin(np.arange(ROWS) / 6.0))
CURRENT = np.round(np.cos(np.arange(ROWS) / 6.0), 2)
FRAME = 0x120
DBC = f"""VERSION ""

NS_ :

BS_:

BU_: DRIVE

BO_ {FRAME} AxisState: 4 DRIVE
 SG_ encoder : 0|16@1- (1,0) [0|0] "count" DRIVE
 SG_ current : 16|16@1- (0.01,0) [0|0] "A" DRIVE
"""


def payloads() -> list[bytes]:
    """The data of the frames, as the DBC describes them."""
    return [
        struct.pack("<hh", int(n), round(100 * float(i)))
        for n, i in zip(POSITION, CURRENT, strict=True)
    ]


def candump() -> str:
    return "".join(
        f"({1_700_000_000 + k * PERIOD_MS / 1000:.6f}) can0 {FRAME:03X}#{data.hex().upper()}\n"
        for k, data in enumerate(payloads())
    )


def write_can(path: Path) -> None:
    """A BLF or an ASC file, by its ending."""
    import can

    with can.Logger(path) as log:
        for k, data in enumerate(payloads()):
            log.on_message_received(
                can.Message(
                    timestamp=1_700_000_000 + k * PERIOD_MS / 1000,
                    arbitration_id=FRAME,
                    is_extended_id=False,
                    data=data,
                )
            )


def write_tdms(path: Path) -> None:
    from nptdms import ChannelObject, TdmsWriter

    clock = {
        "wf_start_time": np.datetime64("2026-01-31T23:59:59"),
        "wf_increment": PERIOD_MS / 1000,
        "wf_start_offset": 0.0,
    }
    with TdmsWriter(str(path)) as writer:
        for part in (slice(0, 30), slice(30, ROWS)):
            writer.write_segment(
                [
                    ChannelObject("axis", "encoder", POSITION[part].astype(np.int32), clock),
                    ChannelObject(
                        "axis", "current", CURRENT[part], clock | {"unit_string": "Amperes"}
                    ),
                    ChannelObject("slow", "temperature", np.arange(3.0) + part.start, {}),
                ]
            )


def write_timetable(path: Path, version: str) -> None:
    """A MATLAB file of version "v7" or "v7.3" with one timetable."""
    import matio
    import pandas

    times = pandas.to_timedelta(np.arange(ROWS) * PERIOD_MS, unit="ms")
    axis = pandas.DataFrame(
        {"encoder": POSITION, "current": CURRENT}, index=pandas.Index(times, name="Time")
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # mat-io stores durations of ns in its own unit
        matio.save_to_mat(str(path), {"axis": axis}, version=version)


def ulog() -> bytes:
    """A ULog with one topic, after its format: header, flags, format, subscription, data."""

    def message(kind: str, content: bytes) -> bytes:
        return struct.pack("<HB", len(content), ord(kind)) + content

    fields = b"axis_state:uint64_t timestamp;float encoder;float current;"
    data = b"".join(
        message("D", struct.pack("<HQff", 0, 1_000_000 + 1000 * PERIOD_MS * k, n, i))
        for k, (n, i) in enumerate(zip(POSITION.tolist(), CURRENT.tolist(), strict=True))
    )
    return (
        b"ULog\x01\x12\x35\x01"
        + struct.pack("<Q", 1_000_000)
        + message("B", bytes(40))
        + message("F", fields)
        + message("A", struct.pack("<BH", 0, 0) + b"axis_state")
        + data
    )

"""Reading of ROS 2 JointState messages, compared with the mcap reader and its ROS 2 decoder."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_ros2._dynamic import serialize_dynamic
from mcap_ros2.decoder import DecoderFactory

from benchmarks.timing import pair
from frictool.logs.recordings.recording_format import tables

MESSAGES = 60_000
PEER_MESSAGES = (
    6_000  # the peer is slow: it is timed on fewer messages, and both are given per second
)
COLUMN = "/joint_states.position[arm]"
SEPARATOR = "=" * 80
JOINT_STATE = (
    "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] "
    "effort\n"
    f"{SEPARATOR}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
    f"{SEPARATOR}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
)


def _write(path: Path, messages: int, interleaved: bool) -> None:
    """Write a recording of two joints at 1 kHz.

    interleaved: True to add a message of another topic after each JointState.
    """
    states = serialize_dynamic("sensor_msgs/msg/JointState", JOINT_STATE)[
        "sensor_msgs/msg/JointState"
    ]
    number = serialize_dynamic("std_msgs/msg/Float64", "float64 data\n")["std_msgs/msg/Float64"]
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros2")
        schema = writer.register_schema(
            "sensor_msgs/msg/JointState", "ros2msg", JOINT_STATE.encode()
        )
        joints = writer.register_channel("/joint_states", "cdr", schema)
        motor = writer.register_channel(
            "/motor",
            "cdr",
            writer.register_schema("std_msgs/msg/Float64", "ros2msg", b"float64 data\n"),
        )
        for k in range(messages):
            at = k * 1_000_000
            content = {
                "header": {
                    "stamp": {"sec": k // 1000, "nanosec": k % 1000 * 1_000_000},
                    "frame_id": "base",
                },
                "name": ["arm", "leg"],
                "position": [k * 0.1, 1.0],
                "velocity": [0.5, 0.5],
                "effort": [0.25, 0.25],
            }
            writer.add_message(joints, at, states(content), at)
            if interleaved:
                writer.add_message(motor, at, number({"data": k * 0.5}), at)
        writer.finish()


def _ours(path: Path) -> list[float]:
    table = next(table for table in tables(path, None) if table.topic == "/joint_states")
    found: list[float] = np.concatenate(
        [block.columns[COLUMN] for block, _ in table.blocks([COLUMN])]
    ).tolist()
    return found


def _theirs(path: Path) -> list[float]:
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        return [
            decoded.position[0]
            for _, _, _, decoded in reader.iter_decoded_messages(topics=["/joint_states"])
        ]


def _row(identity: str, interleaved: bool) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        whole, part = Path(folder, "whole.mcap"), Path(folder, "part.mcap")
        _write(whole, MESSAGES, interleaved)
        _write(part, PEER_MESSAGES, interleaved)
        a, b = pair(lambda: _ours(whole), lambda: _theirs(part), 5)
        same = _ours(part) == _theirs(part)
    speed, peer = MESSAGES / a, PEER_MESSAGES / b
    accuracy = f"CRCs checked; same values: {same}"
    return {
        "id": identity,
        "peer": "mcap + mcap-ros2",
        "ours": speed,
        "theirs": peer,
        "unit": "messages/s",
        "ratio": speed / peer,
        "accuracy": accuracy,
    }


def recording_joint_states() -> dict[str, Any]:
    """Return the row of a recording with one topic."""
    return _row("recording.joint_states", interleaved=False)


def recording_interleaved() -> dict[str, Any]:
    """Return the row of a recording in which messages of two topics alternate."""
    return _row("recording.interleaved", interleaved=True)


ROWS = [recording_joint_states, recording_interleaved]

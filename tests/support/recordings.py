"""Recordings for the tests, written by other tools alone: the mcap library with its ROS 2 and
protobuf writers, rosbags.

python -m tests.support.recordings    writes the golden recordings anew
"""

from __future__ import annotations

import io
import json
import struct
import tempfile
import zlib
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from google.protobuf.descriptor_pb2 import (
    FieldDescriptorProto,
    FileDescriptorProto,
    FileDescriptorSet,
)
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass
from google.protobuf.timestamp_pb2 import Timestamp
from mcap.data_stream import RecordBuilder
from mcap.records import Chunk
from mcap.writer import Writer
from mcap_ros2._dynamic import serialize_dynamic
from rosbags.rosbag1 import Writer as BagWriter
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Bag2Writer
from rosbags.typesys import Stores, get_typestore

from tests.support.example_logs import ROOT

GOLDEN = Path(__file__).parents[1] / "logs" / "golden"
SEPARATOR = "=" * 80
STAMP = "int32 sec\nuint32 nanosec\n"
HEADER = (
    f"builtin_interfaces/Time stamp\nstring frame_id\n{SEPARATOR}\nMSG: "
    f"builtin_interfaces/Time\n{STAMP}"
)
JOINT_STATE = (
    "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] "
    "effort\n"
    f"{SEPARATOR}\nMSG: std_msgs/Header\n{HEADER}"
)
IMU = (
    "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] "
    "orientation_covariance\n"
    "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
    "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n"
    f"{SEPARATOR}\nMSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w 1\n"
    f"{SEPARATOR}\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
    f"{SEPARATOR}\nMSG: std_msgs/Header\n{HEADER}"
)
START = 1_700_000_000_123_456_789  # ns of the epoch: no float64 holds it
PERIOD = 1_000_000
DELAY = 250_000  # ns from the stamp to the recorder


class Sent(NamedTuple):
    """A message: topic, type, definition, when it was recorded, content; its encoding is that of
    the function that writes it."""

    topic: str
    kind: str
    text: str
    time: int
    content: dict[str, Any]


def stamp(time: int) -> dict[str, int]:
    return {"sec": time // 10**9, "nanosec": time % 10**9}


def joint_states(
    position: Sequence[float],
    names: Sequence[str] = ("arm", "leg"),
    start: int = START,
    frame: str = "base",
) -> list[Sent]:
    """The first joint at `position`, the others at its index; velocities count messages, there are
    no efforts."""
    sent = []
    for k, value in enumerate(position):
        others = [float(joint) for joint in range(1, len(names))]
        header = {"stamp": stamp(start + k * PERIOD), "frame_id": frame}
        content = {
            "header": header,
            "name": list(names),
            "position": [value, *others],
            "velocity": [k + 0.5] * len(names),
            "effort": [],
        }
        sent.append(
            Sent(
                "/joint_states",
                "sensor_msgs/msg/JointState",
                JOINT_STATE,
                start + k * PERIOD + DELAY,
                content,
            )
        )
    return sent


def float64s(values: Sequence[float], topic: str = "/motor", start: int = START) -> list[Sent]:
    return [
        Sent(
            topic, "std_msgs/msg/Float64", "float64 data\n", start + k * PERIOD + DELAY, {"data": v}
        )
        for k, v in enumerate(values)
    ]


def in_order(*sent: Iterable[Sent]) -> list[Sent]:
    return sorted((one for some in sent for one in some), key=lambda one: one.time)


def ros2_mcap(sent: Iterable[Sent], **options: Any) -> bytes:
    """CDR messages, as a ROS 2 recorder leaves them."""
    encoders: dict[str, Any] = {}

    def encoded(one: Sent) -> bytes:
        if one.kind not in encoders:
            encoders[one.kind] = serialize_dynamic(one.kind, one.text)[one.kind]
        data: bytes = encoders[one.kind](one.content)
        return data

    return _mcap(
        ((one, encoded(one), "cdr", "ros2msg", one.text.encode()) for one in sent),
        "ros2",
        **options,
    )


IDL = """module rig { module msg { struct Joint {
  long count; sequence<double, 4> taps; double angle; }; }; };
"""


def idl_mcap(angle: Sequence[float]) -> bytes:
    """CDR with its definition in IDL."""
    text = "int32 count\nfloat64[<=4] taps\nfloat64 angle\n"
    encode = serialize_dynamic("rig/msg/Joint", text)["rig/msg/Joint"]
    sent = [
        Sent(
            "/joint", "rig/msg/Joint", "", k, {"count": k, "taps": [0.5] * (k % 5), "angle": value}
        )
        for k, value in enumerate(angle)
    ]
    return _mcap(
        ((one, encode(one.content), "cdr", "ros2idl", IDL.encode()) for one in sent), "ros2"
    )


def ros1_mcap(position: Sequence[float]) -> bytes:
    """Return the MCAP file to which a ROS 1 bag is converted."""
    store = get_typestore(Stores.ROS1_NOETIC)
    kind = "sensor_msgs/msg/JointState"
    text = store.generate_msgdef(kind, ros_version=1)[0].encode()
    messages = enumerate(_messages(store, position, seq=True))
    sent = (
        (
            Sent("/joint_states", "sensor_msgs/JointState", "", START + k, {}),
            bytes(store.serialize_ros1(one, kind)),
        )
        for k, one in messages
    )
    return _mcap(((one, data, "ros1", "ros1msg", text) for one, data in sent), "ros1")


def json_mcap(sent: Iterable[Sent], schema: bool = True, **options: Any) -> bytes:
    form = ("jsonschema", b'{"type": "object"}') if schema else ("", b"")
    return _mcap(
        ((one, json.dumps(one.content).encode(), "json", *form) for one in sent), "", **options
    )


def _mcap(
    messages: Iterable[tuple[Sent, bytes, str, str, bytes]], profile: str, **options: Any
) -> bytes:
    out = io.BytesIO()
    writer = Writer(out, **options)
    writer.start(profile)
    channels: dict[str, int] = {}
    for one, data, encoding, form, text in messages:
        if one.topic not in channels:
            schema = writer.register_schema(one.kind, form, text) if form else 0
            channels[one.topic] = writer.register_channel(one.topic, encoding, schema)
        writer.add_message(channels[one.topic], one.time, data, one.time)
    writer.finish()
    return out.getvalue()


def drive_class() -> tuple[type[Any], bytes]:
    """A protobuf message `rig.Drive` and the descriptors that a recording carries: stamp, number,
    enumeration, message, repeated, map."""
    scalar, many = FieldDescriptorProto.LABEL_OPTIONAL, FieldDescriptorProto.LABEL_REPEATED
    file = FileDescriptorProto(
        name="rig.proto",
        package="rig",
        syntax="proto3",
        dependency=["google/protobuf/timestamp.proto"],
    )
    file.enum_type.add(name="State").value.add(name="OFF", number=0)
    file.enum_type[0].value.add(name="ON", number=3)
    phase = file.message_type.add(name="Phase")
    phase.field.add(name="current", number=1, label=scalar, type=FieldDescriptorProto.TYPE_FLOAT)
    drive = file.message_type.add(name="Drive")
    kinds = FieldDescriptorProto
    drive.field.add(
        name="timestamp",
        number=1,
        label=scalar,
        type=kinds.TYPE_MESSAGE,
        type_name=".google.protobuf.Timestamp",
    )
    drive.field.add(name="angle", number=2, label=scalar, type=kinds.TYPE_DOUBLE)
    drive.field.add(
        name="state", number=3, label=scalar, type=kinds.TYPE_ENUM, type_name=".rig.State"
    )
    drive.field.add(
        name="phases", number=4, label=many, type=kinds.TYPE_MESSAGE, type_name=".rig.Phase"
    )
    drive.field.add(name="counts", number=5, label=many, type=kinds.TYPE_SINT64)
    drive.field.add(name="note", number=6, label=scalar, type=kinds.TYPE_STRING)
    stamps = FileDescriptorProto()
    Timestamp.DESCRIPTOR.file.CopyToProto(stamps)
    pool = DescriptorPool()
    for one in (stamps, file):
        pool.Add(one)
    return GetMessageClass(pool.FindMessageTypeByName("rig.Drive")), FileDescriptorSet(
        file=[file, stamps]
    ).SerializeToString()


def long_joint_states(path: Path, messages: int, at_once: int = 5000) -> None:
    """JointStates at 1 kHz in plain chunks, of which the first was written by the library and the
    others repeat it with other numbers."""
    one = joint_states([0.0])[0]
    payload = serialize_dynamic(one.kind, one.text)[one.kind](one.content)
    fields = [
        ("opcode", "u1"),
        ("length", "<u8"),
        ("channel", "<u2"),
        ("sequence", "<u4"),
        ("log", "<u8"),
        ("publish", "<u8"),
        ("head", "<u4"),
    ]
    size = len(payload)
    position = payload.index(struct.pack("<dd", 0.0, 1.0))
    dtype = np.dtype(
        [
            *fields,
            ("sec", "<i4"),
            ("nanosec", "<u4"),
            ("rest", f"V{position - 12}"),
            ("position", "<f8"),
            ("end", f"V{size - position - 8}"),
        ]
    )
    template = np.frombuffer(struct.pack("<BQHIQQ", 5, 22 + size, 1, 0, 0, 0) + payload, dtype)
    with path.open("wb") as stream:
        writer = Writer(stream, use_chunking=False)
        writer.start("ros2")
        writer.register_channel(
            one.topic, "cdr", writer.register_schema(one.kind, "ros2msg", one.text.encode())
        )
        for first in range(0, messages, at_once):
            count = np.arange(first, min(first + at_once, messages))
            records = np.repeat(template, count.size)
            time = START + count * PERIOD
            records["log"] = records["publish"] = time + DELAY
            records["sec"], records["nanosec"] = time // 10**9, time % 10**9
            records["position"] = 0.01 * np.abs(count % 1000 - 500)
            data = records.tobytes()
            builder = RecordBuilder()
            Chunk("", data, int(time[-1]), int(time[0]), zlib.crc32(data), len(data)).write(builder)
            stream.write(builder.end())
        writer.finish()


def protobuf_mcap(angle: Sequence[float]) -> bytes:
    Drive, descriptors = drive_class()
    messages = []
    for k, value in enumerate(angle):
        time = START + k * PERIOD
        at = {"seconds": time // 10**9, "nanos": time % 10**9}
        data = Drive(
            timestamp=at,
            angle=value,
            state=3,
            phases=[{"current": 0.5}, {"current": k}],
            counts=[k, -k],
            note="x",
        ).SerializeToString()
        messages.append(
            (
                Sent("/drive", "rig.Drive", "", time + DELAY, {}),
                data,
                "protobuf",
                "protobuf",
                descriptors,
            )
        )
    return _mcap(messages, "")


def ros1_bag(
    path: Path, position: Sequence[float], compression: str = "none", chunk_bytes: int = 1 << 20
) -> None:
    """JointStates as ROS 1 records them, written by rosbags."""
    store = get_typestore(Stores.ROS1_NOETIC)
    writer = BagWriter(path)
    writer.chunk_threshold = chunk_bytes
    if compression != "none":
        writer.set_compression(BagWriter.CompressionFormat[compression.upper()])
    with writer:
        connection = writer.add_connection(
            "/joint_states", "sensor_msgs/msg/JointState", typestore=store
        )
        for k, message in enumerate(_messages(store, position, seq=True)):
            writer.write(
                connection,
                START + k * PERIOD + DELAY,
                store.serialize_ros1(message, "sensor_msgs/msg/JointState"),
            )


def ros2_bag(folder: Path, position: Sequence[float], storage: str = "sqlite3") -> None:
    """The same as a folder of ROS 2."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    with Bag2Writer(folder, version=9, storage_plugin=StoragePlugin[storage.upper()]) as writer:
        connection = writer.add_connection(
            "/joint_states", "sensor_msgs/msg/JointState", typestore=store
        )
        for k, message in enumerate(_messages(store, position, seq=False)):
            writer.write(
                connection,
                START + k * PERIOD + DELAY,
                bytes(store.serialize_cdr(message, "sensor_msgs/msg/JointState")),
            )


def _messages(store: Any, position: Sequence[float], seq: bool) -> Iterable[Any]:
    types = store.types
    JointState, Header, Time = (
        types[name]
        for name in (
            "sensor_msgs/msg/JointState",
            "std_msgs/msg/Header",
            "builtin_interfaces/msg/Time",
        )
    )
    for k, value in enumerate(position):
        time = START + k * PERIOD
        header = Header(*([k] if seq else []), Time(time // 10**9, time % 10**9), "base")
        yield JointState(
            header, ["arm", "leg"], np.array([value, 1.0]), np.array([k + 0.5] * 2), np.array([])
        )


GOLDEN_POSITION = [0.0, 0.1, -2.5, 1e-9]


def main() -> None:
    """The golden recordings: 4 messages of 2 joints, and the same numbers in protobuf."""
    (GOLDEN / "joint_states.mcap").write_bytes(
        ros2_mcap(in_order(joint_states(GOLDEN_POSITION), float64s(GOLDEN_POSITION)))
    )
    (GOLDEN / "drive.mcap").write_bytes(protobuf_mcap(GOLDEN_POSITION))
    with tempfile.TemporaryDirectory() as folder:
        ros1_bag(Path(folder, "joint_states.bag"), GOLDEN_POSITION, "lz4")
        ros2_bag(Path(folder, "bag"), GOLDEN_POSITION)
        (GOLDEN / "joint_states.bag").write_bytes(Path(folder, "joint_states.bag").read_bytes())
        (GOLDEN / "joint_states.db3").write_bytes(Path(folder, "bag", "bag.db3").read_bytes())


if __name__ == "__main__":
    main()


CLUTCH = ROOT / "configs" / "clutch" / "bench.yaml"
COLUMNS = """columns:
  position: {column: "/joint_states.position[clutch]", unit: rad}
  current: {column: "/joint_states.effort[clutch]", unit: A}   # this driver puts the current there
"""

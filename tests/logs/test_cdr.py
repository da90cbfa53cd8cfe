"""Numbers out of serialised messages, against the libraries that wrote them: mcap-ros2-support for
CDR, rosbags for others."""

from __future__ import annotations

from contextlib import suppress
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap_ros2._dynamic import generate_dynamic, serialize_dynamic
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from frictool.logs.recordings.cdr import MOST_LAYOUTS, MessageDecoder
from frictool.logs.recordings.ros_definitions import DEFINITIONS
from frictool.logs.recordings.ros_idl import parse_idl
from frictool.logs.recordings.ros_message import NUMBERS, parse_message
from frictool.logs.recordings.serialised_messages import pack_messages
from tests.support.recordings import IMU, JOINT_STATE, joint_states, ros2_mcap

RANGES = {
    "u1": (0, 255),
    "i1": (-128, 127),
    "u2": (0, 65535),
    "i2": (-32768, 32767),
    "u4": (0, 2**32 - 1),
    "i4": (-(2**31), 2**31 - 1),
}
OTHERS = "uint8 flag\nstring note\nfloat64[] values\nint16 last\nduration span\n"
FLAT = [
    kind for kind in NUMBERS if kind not in ("byte", "char", "int64", "uint64")
]  # the oracle has its own opinion of a char's sign


def value_of(kind: str) -> st.SearchStrategy[Any]:
    if kind == "bool":
        return st.booleans()
    if kind == "float64":
        return st.floats(allow_nan=False)
    if kind == "float32":
        return st.floats(width=32, allow_nan=False)
    return st.integers(*RANGES[NUMBERS[kind]])


@st.composite
def definitions(draw: st.DrawFn) -> tuple[str, st.SearchStrategy[dict[str, Any]]]:
    """A message of scalars, arrays, texts and messages within messages, and its contents."""
    inner = draw(st.lists(st.sampled_from([*FLAT, "string"]), min_size=0, max_size=4))
    inner_values = st.fixed_dictionaries(
        {
            f"in{k}": st.text(max_size=5) if kind == "string" else value_of(kind)
            for k, kind in enumerate(inner)
        }
    )
    lines, values = [], {}
    for k in range(draw(st.integers(1, 6))):
        kind = draw(st.sampled_from([*FLAT, "string", "Inner"]))
        array = draw(st.sampled_from(["", "[]", "[3]", "[<=4]"]))
        one = (
            inner_values
            if kind == "Inner"
            else st.text(max_size=6)
            if kind == "string"
            else value_of(kind)
        )
        size = (3, 3) if array == "[3]" else (0, 4)
        values[f"f{k}"] = st.lists(one, min_size=size[0], max_size=size[1]) if array else one
        lines.append(f"{kind}{array} f{k}")
    text = (
        "\n".join(lines)
        + "\n"
        + "=" * 80
        + "\nMSG: rig/Inner\n"
        + "".join(f"{kind} in{k}\n" for k, kind in enumerate(inner))
    )
    return text, st.fixed_dictionaries(values)


def plain(found: Any, path: str = "") -> dict[str, float]:
    """The slow reference: every number of an object by its path."""
    if isinstance(found, bool | int | float):
        return {path: float(found)}
    if isinstance(found, str):
        return {}
    if isinstance(found, dict):
        return {
            key: value
            for name, part in found.items()
            for key, value in plain(part, f"{path}.{name}" if path else name).items()
        }
    return {
        key: value
        for k, part in enumerate(found)
        for key, value in plain(part, f"{path}[{k}]").items()
    }


@given(st.data())
def test_what_the_oracle_writes_is_read(data: st.DataObject):
    """Messages of one type, of any lengths of texts and sequences, in one batch; every number of
    each."""
    text, content = data.draw(definitions())
    contents = data.draw(st.lists(content, min_size=1, max_size=8))
    encode = serialize_dynamic("rig/Test", text)["rig/Test"]
    payloads = [encode(one) for one in contents]
    assert all(generate_dynamic("rig/Test", text)["rig/Test"](payload) for payload in payloads)
    decoder = MessageDecoder(parse_message("rig/msg/Test", text))
    wanted = [plain(one) for one in contents]
    assert [set(decoder.names(payload)) for payload in payloads] == [set(one) for one in wanted]
    paths = tuple(dict.fromkeys(path for one in wanted for path in one))
    values, present, failed = decoder.columns(pack_messages([0] * len(payloads), payloads), paths)
    assert not failed
    assert present.tolist() == [[path in one for one in wanted] for path in paths]
    expected = np.array([[one.get(path, np.nan) for one in wanted] for path in paths]).reshape(
        len(paths), len(wanted)
    )
    assert np.array_equal(values, expected, equal_nan=True)


@cache
def typestore(store: Stores) -> Any:
    types = get_typestore(store)
    duration = "builtin_interfaces/Duration" if store is Stores.ROS2_HUMBLE else "duration"
    types.register(get_types_from_msg(OTHERS.replace("duration", duration), "rig/msg/Test"))
    return types


@pytest.mark.parametrize(
    ("store", "aligned"), [(Stores.ROS2_HUMBLE, True), (Stores.ROS1_NOETIC, False)]
)
@given(
    st.lists(
        st.tuples(st.text(max_size=7), st.lists(st.floats(allow_nan=False), max_size=4)),
        min_size=1,
        max_size=6,
    ),
    st.booleans(),
)
def test_both_byte_orders_and_ros_1(
    store: Stores, aligned: bool, rows: list[tuple[str, list[float]]], little: bool
):
    text = OTHERS.replace("duration", "builtin_interfaces/Duration" if aligned else "duration")
    types = typestore(store)
    Test, Duration = types.types["rig/msg/Test"], types.types["builtin_interfaces/msg/Duration"]
    messages = [Test(7, note, np.array(values), -3, Duration(-5, 6)) for note, values in rows]
    if aligned:
        payloads = [
            bytes(types.serialize_cdr(one, "rig/msg/Test", little_endian=little))
            for one in messages
        ]
    else:
        payloads = [bytes(types.serialize_ros1(one, "rig/msg/Test")) for one in messages]
    decoder = MessageDecoder(parse_message("rig/msg/Test", text), aligned)
    values, present, failed = decoder.columns(
        pack_messages([0] * len(rows), payloads),
        ("flag", "values[1]", "last", "span.sec", "span.nanosec"),
    )
    assert not failed
    assert present[[0, 2, 3, 4]].all()
    assert values[[0, 2, 3, 4]].tolist() == [[one] * len(rows) for one in (7.0, -3.0, -5.0, 6.0)]
    assert np.array_equal(
        values[1], [given[1] if len(given) > 1 else np.nan for _, given in rows], equal_nan=True
    )


def joint_payloads(names: list[tuple[str, ...]]) -> list[bytes]:
    encode = serialize_dynamic("sensor_msgs/msg/JointState", JOINT_STATE)[
        "sensor_msgs/msg/JointState"
    ]
    return [encode(joint_states([k + 0.25], joints)[0].content) for k, joints in enumerate(names)]


def test_elements_are_called_by_the_names_beside_them_whatever_their_order():
    """Names of one length each: only the guarded bytes of the texts tell the orders apart."""
    orders = [("arm", "leg"), ("leg", "arm"), ("arm", "leg"), ("hip", "arm"), ("hip", "leg")]
    decoder = MessageDecoder(parse_message("sensor_msgs/msg/JointState", JOINT_STATE))
    values, present, failed = decoder.columns(
        pack_messages([0] * 5, joint_payloads(orders)),
        ("position[arm]", "position[0]", "velocity[arm]"),
    )
    assert not failed
    assert np.array_equal(values[0], [0.25, 1.0, 2.25, 1.0, np.nan], equal_nan=True)
    assert values[1].tolist() == [0.25, 1.25, 2.25, 3.25, 4.25]
    assert present.tolist() == [[True] * 4 + [False], [True] * 5, [True] * 4 + [False]]


def test_more_layouts_than_are_kept_give_the_same_numbers():
    orders = [("j" * (k % 97 + 1), "arm") for k in range(4 * MOST_LAYOUTS)]
    decoder = MessageDecoder(parse_message("sensor_msgs/msg/JointState", JOINT_STATE))
    values, present, failed = decoder.columns(
        pack_messages([0] * len(orders), joint_payloads(orders)), ("position[0]", "position[arm]")
    )
    assert values[0].tolist() == [k + 0.25 for k in range(len(orders))]
    assert (values[1] == 1.0).all()
    assert present.all()
    assert not failed


@given(at=st.integers(0, 10**6), flip=st.integers(1, 255), cut=st.integers(0, 120))
def test_a_damaged_message_fails_alone(at: int, flip: int, cut: int):
    """Any byte wrong, or the end missing: that message gives some numbers or a reason, the others
    what they are."""
    payloads = joint_payloads([("arm", "leg")] * 5)
    damaged = bytearray(payloads[2])
    damaged[at % len(damaged)] ^= flip
    payloads[2] = bytes(damaged)[: len(damaged) - cut]
    decoder = MessageDecoder(parse_message("sensor_msgs/msg/JointState", JOINT_STATE))
    values, _, failed = decoder.columns(pack_messages([0] * 5, payloads), ("position[0]",))
    assert set(failed) <= {2}
    assert all(reason and "\n" not in reason for reason in failed.values())
    assert values[0][[0, 1, 3, 4]].tolist() == [0.25, 1.25, 3.25, 4.25]


@pytest.mark.parametrize(
    ("payload", "reason"),
    [
        (b"", "begins with nothing; allowed: plain CDR"),
        (b"\0\3\0\0" + bytes(60), "begins with 00 03 00 00; allowed: plain CDR"),
        (b"\0\1\0\0" + bytes(8) + b"\xff\xff\xff\xff" + bytes(40), "declares 4294967295 elements"),
        (b"\0\1\0\0" + bytes(8) + b"\1\0\0\0\0\0\0\0" + bytes(60), "its definition ends after"),
    ],
)
def test_what_is_no_message_of_the_type_is_told(payload: bytes, reason: str):
    decoder = MessageDecoder(parse_message("sensor_msgs/msg/JointState", JOINT_STATE))
    with pytest.raises(ValueError, match=reason):
        decoder.names(payload)


def test_a_message_of_endless_fields_is_refused_soon():
    """Sequences of empty messages of ROS 1 take no bytes: a length is all there is."""
    text = "Row[] rows\n===\nMSG: rig/Row\nNothing[] none\nuint8[] rest\n===\nMSG: rig/Nothing\n"
    payload = (1000).to_bytes(4, "little") + ((200_000).to_bytes(4, "little") + bytes(4)) * 30_000
    with pytest.raises(ValueError, match="more than 200000 fields"):
        MessageDecoder(parse_message("rig/Test", text), aligned=False).names(payload)


def test_definitions_are_read_as_ros_reads_them():
    text = "\n".join(
        [
            "# a comment",
            'string<=10 note "a # b"',
            "uint8 OFF=0",
            "string NAME=x # y",
            "float32[<=4] gains [1.0, 2.0]  # bounded, with a default",
            "Header header",
            "pkg/Other[2] others",
            "===",
            "MSG: pkg/msg/Other",
            "wstring wide",
            "===",
            "MSG: std_msgs/Header",
            "time stamp",
        ]
    )
    fields = {one.name: one for one in parse_message("rig/msg/Test", text).fields}
    assert [(name, one.repeat, one.size) for name, one in fields.items()] == [
        ("note", "once", 0),
        ("gains", "sequence", 0),
        ("header", "once", 0),
        ("others", "fixed", 2),
    ]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("Other x\n", "'rig/Other' is used but not defined"),
        ("float64\n", "'float64' is not a field"),
        ("Test again\n", "nested in more than"),
        (
            "A[] a\n===\nMSG: rig/A\nB[] b\nB[] c\n===\nMSG: rig/B\nA[] a\nA[] b\nA[] c\n",
            "nested in more than",
        ),
    ],
)
def test_definitions_that_are_none_are_refused(text: str, reason: str):
    with pytest.raises(ValueError, match=reason):
        parse_message("rig/Test", text)


IDL = """
// generated
#include "std_msgs/msg/Header.idl"
module sensor_msgs {
  module msg {
    typedef double double__3[3];
    module Joint_Constants { const uint8 OFF = 0; };
    @verbatim (language="comment", text=
      "A message; with } and \\" signs (and brackets.")
    struct Joint {
      @key std_msgs::msg::Header header;
      sequence<string> name;
      sequence<double, 8> position;
      double__3 force;
      @unit (value="rad/s") float speed;
      unsigned long long count;
      octet flag, more;
      string<20> note;
    };
  };
};
================================================================================
IDL: std_msgs/msg/Header
module std_msgs { module msg { struct Header {
  builtin_interfaces::msg::Time stamp; string frame_id; }; }; };
"""


def test_idl_is_the_same_as_the_message_definition():
    text = (
        "std_msgs/Header header\nstring[] name\nfloat64[<=8] position\nfloat64[3] force\nfloat32 "
        "speed\nuint64 count\n"
        "byte flag\nbyte more\nstring<=20 note\n===\nMSG: "
        "std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
    )
    assert parse_idl("sensor_msgs/msg/Joint", IDL) == parse_message("sensor_msgs/msg/Joint", text)


@given(st.integers(0, len(IDL)), st.integers(0, 40))
def test_idl_that_is_cut_or_mangled_is_refused_or_read(at: int, length: int):
    with suppress(ValueError):
        assert parse_idl("sensor_msgs/msg/Joint", IDL[:at] + IDL[at + length :]).fields


@pytest.mark.parametrize(
    "kind", [kind for kind in DEFINITIONS if not kind.startswith("control_msgs/")]
)  # rosbags has none of these
def test_the_definitions_kept_here_are_those_of_ros(kind: str):
    """Against rosbags: the same bytes give the same paths, for every type that ROS 2 Humble has."""
    theirs, _ = typestore(Stores.ROS2_HUMBLE).generate_msgdef(
        kind.replace("/", "/msg/"), ros_version=2
    )
    assert parse_message(kind, DEFINITIONS[kind]) == parse_message(kind, theirs)


def test_imu_has_its_fixed_arrays():
    encode = serialize_dynamic("sensor_msgs/msg/Imu", IMU)["sensor_msgs/msg/Imu"]
    vector = {"x": 1.0, "y": 2.0, "z": 3.0}
    content = {
        "header": {"stamp": {"sec": 1, "nanosec": 2}, "frame_id": ""},
        "orientation": {**vector, "w": 4.0},
        "orientation_covariance": [float(k) for k in range(9)],
        "angular_velocity": vector,
        "angular_velocity_covariance": [0.0] * 9,
        "linear_acceleration": {"x": 9.0, "y": 8.0, "z": 7.0},
        "linear_acceleration_covariance": [0.0] * 9,
    }
    decoder = MessageDecoder(parse_message("sensor_msgs/msg/Imu", IMU))
    values, _, _ = decoder.columns(
        pack_messages([0], [encode(content)]),
        ("linear_acceleration.x", "orientation_covariance[8]", "orientation.w"),
    )
    assert values[:, 0].tolist() == [9.0, 8.0, 4.0]


def test_the_recordings_of_these_tests_are_what_the_library_reads():
    import io

    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    reader = make_reader(
        io.BytesIO(ros2_mcap(joint_states([1.5, 2.5]))), decoder_factories=[DecoderFactory()]
    )
    assert [decoded.position for _, _, _, decoded in reader.iter_decoded_messages()] == [
        [1.5, 1.0],
        [2.5, 1.0],
    ]

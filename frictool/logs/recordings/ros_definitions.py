"""Definitions of common ROS message types, for recordings without definitions.

Bags of ROS 2 before Iron contain only the names of the types.
"""

from __future__ import annotations

from frictool.logs.recordings.ros_message import NUMBERS

_HEADER = "builtin_interfaces/Time stamp\nstring frame_id"
_VECTOR = "float64 x\nfloat64 y\nfloat64 z"
_LAYOUT = "MultiArrayDimension[] dim\nuint32 data_offset"
_STANDARD = {name: name.capitalize().replace("Uint", "UInt") for name in NUMBERS}

_FIELDS: dict[str, str] = {
    **{f"std_msgs/{title}": f"{name} data" for name, title in _STANDARD.items()},
    **{f"std_msgs/{title}MultiArray": f"MultiArrayLayout layout\n{name}[] data"
    for name, title in _STANDARD.items()
    if name not in ("bool", "char")},
    "std_msgs/String": "string data",
    "std_msgs/Header": _HEADER,
    "std_msgs/MultiArrayLayout": _LAYOUT,
    "std_msgs/MultiArrayDimension": "string label\nuint32 size\nuint32 stride",
    "geometry_msgs/Vector3": _VECTOR,
    "geometry_msgs/Point": _VECTOR,
    "geometry_msgs/Quaternion": f"{_VECTOR}\nfloat64 w",
    "geometry_msgs/Pose": "Point position\nQuaternion orientation",
    "geometry_msgs/Twist": "Vector3 linear\nVector3 angular",
    "geometry_msgs/Accel": "Vector3 linear\nVector3 angular",
    "geometry_msgs/Wrench": "Vector3 force\nVector3 torque",
    **{
        f"geometry_msgs/{name}Stamped": f"std_msgs/Header header\n{name} {field}"
        for name, field in (
            ("Vector3", "vector"), ("Point", "point"), ("Quaternion", "quaternion"),
            ("Pose", "pose"),
            ("Twist", "twist"), ("Accel", "accel"), ("Wrench", "wrench"),
        )
    },
    "sensor_msgs/JointState": (
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n"
        "float64[] effort"
    ),
    "sensor_msgs/Imu": (
        "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\n"
        "float64[9] orientation_covariance\n"
        "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
        "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance"
    ),
    "sensor_msgs/Temperature": "std_msgs/Header header\nfloat64 temperature\nfloat64 variance",
    "control_msgs/InterfaceValue": "string[] interface_names\nfloat64[] values",
    "control_msgs/DynamicJointState": (
        "std_msgs/Header header\nstring[] joint_names\nInterfaceValue[] interface_values"
    ),
}  # fmt: skip

_ALL = "".join(f"===\nMSG: {name}\n{fields}\n" for name, fields in _FIELDS.items())
DEFINITIONS = {name: f"{fields}\n{_ALL}" for name, fields in _FIELDS.items()}

"""Starts of log files as public loggers write them: header lines and a few rows, with a motion to
and fro."""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np

K = np.arange(60)
STILL = 0.0 * K


def _rows(columns: Sequence[np.ndarray], mark: str, comma: bool = False) -> str:
    cells = [[f"{value:.10g}" for value in row] for row in zip(*columns, strict=True)]
    return "".join(
        mark.join(cell.replace(".", ",") if comma else cell for cell in row) + "\n" for row in cells
    )


def _sine(scale: float) -> np.ndarray:
    return np.asarray(scale * np.sin(K / 9.0))


def twincat(unit: str = "(None)", mark: str = "\t") -> str:
    """TwinCAT 3 Scope's text export: every line about the channels repeats its key; times are ms,
    and have no name."""
    keys = {
        "Name": ("fActPosition", "fActTorque"),
        "SymbolComment": "",
        "Data-Type": "LREAL",
        "SampleTime[ms]": "1",
        "VariableSize": "8",
        "SymbolBased": "True",
        "IndexGroup": "16448",
        "IndexOffset": "608",
        "SymbolName": "MAIN.fAct",
        "NetID": "5.23.9.1.1.1",
        "Port": "851",
        "Offset": "0",
        "ScaleFactor": "1",
        "BitMask": "0xFFFFFFFFFFFFFFFF",
        "Unit": unit,
        "Unit ScaleFactor": "1",
        "Unit Offset": "0",
    }
    head = [
        ("Name", "Scope Project"),
        ("File", "C:\\scope.tcscopex"),
        ("Starttime of export", "132956925843760000", "Montag, 2. Mai 2022", "10:09:44.376"),
    ]
    both = {
        key: cells if isinstance(cells, tuple) else (cells, cells) for key, cells in keys.items()
    }
    lines = [mark.join(line) for line in head]
    lines += [
        "",
        *(mark.join(f"{key}{mark}{cell}" for cell in cells) for key, cells in both.items()),
    ]
    return "\n".join([*lines, "", _rows([K, _sine(90.0), K, _sine(3.0)], mark, comma=True)])


SIEMENS = "Time;_DriveAxis_1.ActualPosition;_DriveAxis_1.ActualTorque"  # ms
ODRIVE = "time,pos_estimate,vel_estimate,Iq_measured"  # turns
MOTEUS = "timestamp,mode,position,velocity,torque,q_current"  # revolutions
RTDE = "timestamp actual_q_0 actual_q_1 actual_qd_0 actual_qd_1 actual_current_0 actual_current_1"
S1 = (
    "timestamp_ms,mode,command_value,measured_position_deg,measured_velocity_deg_s,"
    "measured_torque_Nm,command_current_A,measured_current_A"
)
VESC = (
    "ms_today;input_voltage;temp_motor;current_motor;d_axis_current;q_axis_current;erpm;"
    "encoder_position;q_axis_voltage"
)
SERVO = "time,Goal_Position,Present_Position,Present_Current,Present_Input_Voltage"
FEETECH = "time,present_position,present_speed,present_load,present_current,present_voltage"
FRANKA = ", ".join(
    [
        "time, success_rate",
        *(
            f"state.{name}[{joint}]"
            for name in ("q", "q_d", "dq", "dq_d", "tau_J", "tau_ext_hat_filtered")
            for joint in range(2)
        ),
    ]
)
RTDE_ALL = ",".join(
    ["timestamp"]
    + [
        f"{name}_{joint}"
        for name in ("actual_q", "actual_current", "target_current", "target_q", "target_current")
        for joint in range(2)
    ]
)
RTDE_POSES = "actual_q_0 actual_q_1 actual_TCP_pose_0 actual_TCP_pose_1"
SERVOS = ",".join(
    ["timestamp"]
    + [f"{name} ({servo})" for servo in (1, 2) for name in ("target pos", "pos", "speed", "temp")]
)
LAAS = "Time, Position, Velocity, Iq, Uq, Vsupply"
# the first versions of libfranka: an empty column before the commands, whose names are repeated
FRANKA_2017 = ", ".join(
    [
        "duration, success rate",
        *(
            f"{name}[{joint}]"
            for name in ("q", "q_d", "dq", "dq_d", "tau_J", "tau_ext_hat_filtered")
            for joint in range(2)
        ),
        "sent commands,q_d[0], q_d[1],tau_J_d[0], tau_J_d[1]",
    ]
)
LOGGERS: dict[str, str] = {
    "twincat": twincat(),
    "siemens": f"{SIEMENS}\n" + _rows([0.125 * K, _sine(90.0), _sine(2.0)], ";"),
    "odrive": f"{ODRIVE}\n" + _rows([0.01 * K, _sine(2.0), _sine(0.3), _sine(5.0)], ","),
    "moteus": f"{MOTEUS}\n"
    + _rows([0.002 * K, STILL + 10, _sine(0.5), _sine(2.0), _sine(0.2), _sine(3.0)], ","),
    "odrive_counts": f"{ODRIVE}\n"
    + _rows([0.01 * K, _sine(20_000.0), _sine(3_000.0), _sine(5.0)], ","),
    "simplefoc": "time,Target,Vq,Vd,Cq,Cd,Vel,Angle\n"
    + _rows([0.01 * K, STILL, *(_sine(size) for size in (3.0, 0.1, 400.0, 5.0, 10.0, 2.0))], ","),
    "vesc": f"{VESC}\n"
    + _rows(
        [
            36_000_000.0 + 20 * K,
            STILL + 24,
            STILL + 30,
            *(_sine(size) for size in (2.0, 0.1, 2.0, 900.0)),
            90 + _sine(60.0),
            _sine(3.0),
        ],
        ";",
    ),
    "dynamixel": f"{SERVO}\n"
    + _rows(
        [
            0.01 * K,
            STILL + 2048,
            np.rint(2048 + _sine(500.0)),
            np.rint(_sine(40.0)),
            STILL + 120,
        ],
        ",",
    ),
    "feetech": f"{FEETECH}\n"
    + _rows(
        [
            0.01 * K,
            np.rint(2048 + _sine(500.0)),
            np.rint(_sine(300.0)),
            STILL,
            np.rint(_sine(20.0)),
            STILL + 120,
        ],
        ",",
    ),
    "feetech_degrees": f"{FEETECH}\n"
    + _rows([0.01 * K, _sine(60.0), _sine(300.0), STILL, np.rint(_sine(20.0)), STILL + 120], ","),
    "franka": f"{FRANKA}\n" + _rows([K, STILL + 1, *(_sine(1.0 + k / 4) for k in range(12))], ","),
    "franka_2017": f"{FRANKA_2017}\n"
    + "".join(
        f"{state},,{command}\n"
        for state, command in zip(
            _rows([K, STILL + 1, *(_sine(1.0 + k / 4) for k in range(12))], ",").splitlines(),
            _rows([_sine(1.6), _sine(1.7), _sine(3.0), _sine(3.1)], ",").splitlines(),
            strict=True,
        )
    ),
    "kinova": _rows(
        [_sine(2.0), _sine(1.0), _sine(0.9), STILL, _sine(1.0), _sine(1.1), _sine(-2.0)], " "
    ),
    "rtde": f"{RTDE}\n"
    + _rows([0.002 * K, STILL, _sine(1.0), STILL, _sine(0.9), STILL, _sine(2.0)], " "),
    # the recorder of a UR with a repeated field, and one without times
    "rtde_repeated": f"{RTDE_ALL}\n"
    + _rows([0.008 * K, *(_sine(1.0 + k) for k in range(4)), *(3 * [_sine(7.0), _sine(8.0)])], ","),
    "rtde_poses": f"{RTDE_POSES}\n" + _rows([_sine(1.0), STILL, _sine(0.2), STILL], " "),
    # VescUart's values as JSON lines; rpm is the electrical speed, inpVoltage the battery's
    "vesc_uart": "".join(
        json.dumps(
            {
                "t": 0.05 * k,
                "avgMotorCurrent": round(4.0 * float(np.sin(k / 9)), 3),
                "avgInputCurrent": 0.5,
                "dutyCycleNow": 0.1,
                "rpm": 900 + k,
                "inpVoltage": 24.1,
                "wattHours": 0.04,
            }
        )
        + "\n"
        for k in K.tolist()
    ),
    # a servo's registers as JSON lines, as a test rig of Dynamixel servos stores them
    "servo_rig": "".join(
        json.dumps(
            {
                "position": round(0.5 * float(np.sin(k / 9)), 5),
                "speed": round(0.3 * float(np.cos(k / 9)), 5),
                "load": k % 7,
                "input_volts": 7.3 + 0.1 * (k % 2),
                "temp": 28,
                "timestamp": round(0.0052 * k, 4),
                "goal_position": round(0.6 * float(np.sin(k / 9)), 5),
                "torque_enable": True,
            }
        )
        + "\n"
        for k in K.tolist()
    ),
    # servos on a bus, each with its number in parentheses
    "servos": f"{SERVOS}\n"
    + _rows(
        [
            0.005 * K,
            *(
                np.rint(column)
                for _ in range(2)
                for column in (2048 + _sine(500.0), 2048 + _sine(499.0), _sine(300.0), STILL + 37)
            ),
        ],
        ",",
    ),
    "torque_sensor": "time [s],position [rad],current [A],joint torque sensor [N m]\n"
    + _rows([0.001 * K, _sine(1.0), _sine(2.0), _sine(9.0)], ","),
    "torque_only": "time [s],position [rad],torque [N m]\n"
    + _rows([0.001 * K, _sine(1.0), _sine(9.0)], ","),
    "torque_cur": "t,Pos [rad],TorqueCur\n" + _rows([0.001 * K, _sine(1.0), _sine(40.0)], ","),
    "sample_index": "t,angle [deg],current [A]\n" + _rows([K, _sine(50.0), _sine(1.0)], ","),
    "odrive_s1": f"{S1}\n"
    + _rows([50.0 * K, STILL + 1, *(_sine(size) for size in (2.0, 90.0, 9.0, 1.0, 2.0, 2.1))], ","),
    "laas": f"{LAAS}\n"
    + _rows([0.001 * K, _sine(300.0), _sine(50.0), _sine(0.1), _sine(1.0), STILL + 0.49], ", "),
}

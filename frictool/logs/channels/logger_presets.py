"""Presets: columns of the logs of known drives and robots, with the units that the files lack.

A new preset is one record in PRESETS. A preset fits a log if a column matches each pattern of the
preset's signature. If several presets fit, no preset is used. If the file does not determine the
unit of a column, the user has to state it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from frictool.documents.bench import OPEN
from frictool.logs.channels.column_names import without_number
from frictool.typing import Vector

NO_CHANNEL = ""


class PresetColumn(NamedTuple):
    """Entry of a preset for the columns whose names match a pattern.

    pattern: regular expression for the whole name of a column; case is ignored.
    channel: channel of these columns; NO_CHANNEL if the columns are not used.
    unit: unit of the values; OPEN if the user has to state it.
    why: reason why the user has to state the unit if it is OPEN; "" if the unit is always known.
    whole: True if the unit is right only for whole numbers.
    most: largest absolute value for which the unit is right.
    """

    pattern: str
    channel: str
    unit: str = OPEN
    why: str = ""
    whole: bool = False
    most: float = np.inf

    def unit_of(self, values: Vector) -> str:
        """Return the unit of these values (n,); OPEN if the user has to state it."""
        finite = values[np.isfinite(values)]
        fits = not self.whole or bool((finite == np.rint(finite)).all())
        return self.unit if fits and not self.exceeded(values) else OPEN

    def exceeded(self, values: Vector) -> bool:
        """Return True if a value is too large for the unit."""
        return bool((np.abs(values[np.isfinite(values)]) > self.most).any())


class LoggerPreset(NamedTuple):
    """Preset for the logs of one maker's drives or robots.

    title: name of the preset in messages.
    signature: patterns of column names. Only the logs of these devices have a column for each
        pattern.
    columns: entries for columns with known channels. The channels of other columns are guessed from
        their names.
    absent: patterns of column names; a log with a matching column is from other devices.
    """

    title: str
    signature: tuple[str, ...]
    columns: tuple[PresetColumn, ...]
    absent: tuple[str, ...] = ()

    def fits(self, names: Sequence[str]) -> bool:
        """Return True if the preset fits a log with the columns `names`."""

        def found(pattern: str) -> bool:
            return any(_matches(pattern, name) for name in names)

        return all(map(found, self.signature)) and not any(map(found, self.absent))

    def entries(self, columns: Mapping[str, Vector]) -> dict[str, PresetColumn]:
        """Return the entry of each known column; the keys are the column names.

        If a value is too large for the unit of its column, the log has other units than the preset.
        The user then has to state the unit of every column with a limit (`most`).
        """
        known = {name: entry for name in columns if (entry := self.column(name)) is not None}
        if not any(entry.exceeded(columns[name]) for name, entry in known.items()):
            return known
        return {
            name: entry if np.isinf(entry.most) else entry._replace(unit=OPEN)
            for name, entry in known.items()
        }

    def column(self, name: str) -> PresetColumn | None:
        """Return the entry for the column `name`; None if the preset does not know the column."""
        return next((one for one in self.columns if _matches(one.pattern, name)), None)


JOINT = r"[\[_ ]?\d\]?"
COUNTS_WHY = "the numbers are not whole, so that they are not counts of the servo"
SERVO_CURRENT = "the step of the current register depends on the model: "
# registers of Dynamixel servos with protocol 2
DYNAMIXEL_ONLY = r"(.*[./])?(present[_ ](input[_ ]voltage|pwm)|realtime[_ ]tick)"
SERVO = (
    PresetColumn(r"(.*[./])?present[_ ]position", "position", "count", COUNTS_WHY, whole=True),
    PresetColumn(r"(.*[./])?goal[_ ]position", "reference", "count", COUNTS_WHY, whole=True),
    PresetColumn(r"(.*[./])?(present|goal)[_ ](velocity|speed|load|pwm)", NO_CHANNEL),
    PresetColumn(r"(.*[./])?present[_ ](input[_ ])?(voltage|temperature)", NO_CHANNEL),
)
PRESETS = (
    LoggerPreset(
        "ODrive",
        (r"(.*[./])?pos_estimate", r"(.*[./])?vel_estimate", r"(.*[./])?iq_(measured|setpoint)"),
        (
            PresetColumn(
                r"(.*[./])?pos_estimate",
                "position",
                "turn",
                "firmware before 0.5 reports counts of the encoder",
                most=1e3,
            ),
            PresetColumn(
                r"(.*[./])?(input_pos|pos_setpoint)",
                "reference",
                "turn",
                "firmware before 0.5 reports counts of the encoder",
                most=1e3,
            ),
            PresetColumn(
                r"(.*[./])?vel_estimate",
                "velocity",
                "turn/s",
                "firmware before 0.5 reports counts of the encoder",
                most=200.0,
            ),
            PresetColumn(r"(.*[./])?iq_measured", "current", "A"),
            PresetColumn(r"(.*[./])?iq_setpoint", "current_command", "A"),
            PresetColumn(r"(.*[./])?(vbus_voltage|ibus|torque_estimate)", NO_CHANNEL),
        ),
    ),
    LoggerPreset(
        "moteus",
        (
            r"(.*[./])?mode",
            r"(.*[./])?position",
            r"(.*[./])?velocity",
            r"(.*[./])?torque",
            r"(.*[./])?q_current",
        ),
        (
            PresetColumn(r"(.*[./])?position", "position", "turn"),
            PresetColumn(r"(.*[./])?velocity", "velocity", "turn/s"),
            PresetColumn(r"(.*[./])?q_current", "current", "A"),
            PresetColumn(r"(.*[./])?(torque|d_current|abs_position|voltage|power)", NO_CHANNEL),
        ),
    ),
    LoggerPreset(
        "SimpleFOC",
        ("target", "vq", "vd", "cq", "cd", "angle"),
        (
            PresetColumn("angle", "position", "rad"),
            PresetColumn("vel", "velocity", "rad/s"),
            PresetColumn("cq", "current", "mA"),
            PresetColumn("vq", "voltage", "V"),
            PresetColumn("target|vd|cd", NO_CHANNEL),
        ),
    ),
    LoggerPreset(
        "VESC Tool",
        ("ms_today", "q_axis_current", "erpm", "encoder_position"),
        (
            PresetColumn("ms_today", "time", "ms"),
            PresetColumn("encoder_position", "position", "deg"),
            PresetColumn("q_axis_current", "current", "A"),
            PresetColumn("q_axis_voltage", "voltage", "V"),
            PresetColumn(
                "ms_today_.*|input_voltage|temp_.*|current_.*|d_axis_.*|erpm|tacho.*|.*_hours.*"
                "|battery_.*|speed_.*|vesc_id|num_vescs|acc.|gyro.|roll|pitch|yaw|gnss_.*",
                NO_CHANNEL,
            ),
        ),
    ),
    LoggerPreset(
        "VESC (VescUart)",
        ("avgmotorcurrent", "dutycyclenow", "inpvoltage"),
        (
            PresetColumn("avgmotorcurrent", "current", "A"),
            PresetColumn(
                "avginputcurrent|dutycyclenow|rpm|inpvoltage|amphours.*|watthours.*|tachometer.*"
                "|.*temp.*|error|id",
                NO_CHANNEL,
            ),
        ),
    ),
    LoggerPreset(
        "Dynamixel",
        (r"(.*[./])?present[_ ]position", DYNAMIXEL_ONLY),
        (
            *SERVO,
            PresetColumn(
                r"(.*[./])?present[_ ]current",
                "current",
                OPEN,
                f"{SERVO_CURRENT}2.69 mA (XM430, XH430), 1 mA (XL330, P), 3.36 mA (MX-64); write "
                "the step as scale, with unit mA",
            ),
        ),
    ),
    LoggerPreset(
        "Feetech or Dynamixel (protocol 1)",
        (
            r"(.*[./])?present[_ ]position",
            r"(.*[./])?present[_ ](load|voltage)",
            r"(.*[./])?present[_ ](speed|velocity)",
        ),
        (
            *SERVO,
            PresetColumn(
                r"(.*[./])?present[_ ]current",
                "current",
                OPEN,
                f"{SERVO_CURRENT}6.5 mA (STS3215); write the step as scale, with unit mA",
            ),
        ),
        absent=(DYNAMIXEL_ONLY,),
    ),
    LoggerPreset(
        "Universal Robots (RTDE)",
        (rf"actual_q{JOINT}", rf"(actual_current|actual_qd|target_q|actual_tcp_pose){JOINT}"),
        (
            PresetColumn("timestamp", "time", "s"),
            PresetColumn(rf"actual_q{JOINT}", "position", "rad"),
            PresetColumn(rf"target_q{JOINT}", "reference", "rad"),
            PresetColumn(rf"actual_qd{JOINT}", "velocity", "rad/s"),
            PresetColumn(rf"actual_current{JOINT}", "current", "A"),
            PresetColumn(rf"target_current{JOINT}", "current_command", "A"),
            PresetColumn(
                r"target_(qd|qdd|moment|tcp).*|actual_(tcp|joint_voltage|main|robot|digital"
                r"|momentum|execution|tool).*|joint_.*|robot_.*|safety_.*|speed_.*|runtime_.*",
                NO_CHANNEL,
            ),
        ),
    ),
    LoggerPreset(
        "Franka (libfranka)",
        # each pattern has the names of the present and of the first versions of libfranka
        (
            "time|duration",
            "success[_ ]rate",
            rf"(state\.)?q{JOINT}",
            rf"(state\.)?tau_j{JOINT}",
        ),
        (
            PresetColumn("time|duration", "time", "ms"),
            PresetColumn(rf"(state\.)?q{JOINT}", "position", "rad"),
            PresetColumn(rf"((state|cmd)\.)?q_d{JOINT}", "reference", "rad"),
            PresetColumn(rf"(state\.)?dq{JOINT}", "velocity", "rad/s"),
            PresetColumn(rf"(state\.)?tau_j{JOINT}", "effort", "N m"),
            PresetColumn(
                r"success[_ ]rate|sent commands|((state|cmd)\.|dq_d|tau_ext|tau_j_d|o_).*",
                NO_CHANNEL,
            ),
        ),
    ),
)


def preset_of(names: Sequence[str]) -> LoggerPreset | None:
    """Return the preset of a log with these columns; None if no preset or several presets fit."""
    fitting = [one for one in PRESETS if one.fits(names)]
    return fitting[0] if len(fitting) == 1 else None


def _matches(pattern: str, name: str) -> bool:
    return re.fullmatch(pattern, without_number(name.strip()), re.IGNORECASE) is not None

"""Choice of the column and the unit of each channel; the user is asked if the file does not decide.

    fit       a column fits a channel if its unit has the channel's dimension and its name denotes
              the quantity; if no name denotes the quantity, the unit suffices
    choice    the fitting column with the clearest name; a question if several names are equally
              clear
    unit      the unit in the file, else the unit at the end of the name; a question if both are
              missing

In three cases, a missing unit is inferred without a question. Joint states of ROS recordings are in
SI. Integers in a column that is named after an encoder are counts. Times with steps of 1e-5 to 0.02
are in seconds.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from typing import get_args

import numpy as np

from frictool.documents.bench import COUNT, OPEN, Channel
from frictool.documents.quantity import (
    CHANNEL_DIMENSIONS,
    SERVO_CHANNELS,
    Axis,
    si_unit,
    unit_scale,
)
from frictool.logs.arrays.memory_table import MemoryTable
from frictool.logs.channels.column_names import (
    PERCENT,
    QUANTITIES,
    UNITS,
    clarity,
    is_command,
    is_connector,
    is_no_signal,
    quantities,
    unit_in,
    without_number,
    words,
)
from frictool.logs.channels.logger_presets import NO_CHANNEL, PresetColumn
from frictool.logs.channels.mapping import EFFORT, TIME
from frictool.logs.channels.question import ColumnQuestion
from frictool.logs.quality.time_base import encoder_step
from frictool.typing import Vector

TEMPERATURE = "temperature"
CHANNELS: tuple[str, ...] = get_args(Channel)
DRIVES = ("current", "voltage")
CLEAR = 2  # words in the first CLEAR levels of QUANTITIES overrule a unit
PROCESS = 3  # level of QUANTITIES with the suffixes of a process controller's tag
# words that the name of a position command may contain besides a word for a command; the words of
# the position's name are added
NEUTRAL = {"value", "input", "signal", "axis", "joint", "motor", "achse"}
MOST_NAMES = 8  # maximum number of column names in a question
COUNTS = (COUNT, "counts", "ticks", "inc", "increments")
# a time without unit is in s if its steps are in this range: no logger has such short steps in ms
SECONDS = (1e-5, 0.02)
FEWEST_STEPS = 8  # least number of rows of a column that may be a row number
STEP_TOLERANCE = 0.02  # relative difference of the steps of a time, from rounding in the file
CANDIDATES: dict[str, tuple[str, str]] = {  # dimension -> candidate units, rotary and linear
    TIME: ("s, ms, us", "s, ms, us"),
    "position": ("rad, deg, turn, count", "m, mm, count"),
    "velocity": ("rad/s, deg/s, turn/s, rpm", "m/s, mm/s"),
    "current": ("A, mA", "A, mA"),
    "voltage": ("V, mV", "V, mV"),
    EFFORT: ("N m, mN m", "N"),
    TEMPERATURE: ("degC, K", "degC, K"),
}
MOTION = ("position", "velocity")
SCALED = ("temperature", TIME)  # dimensions that no log states in per cent of a full scale
LABEL = re.compile(r"\[([^\]]*)\]$")  # joint name at the end of a recording's column
_JOINT_STATE = re.compile(r"/.*\.(position|velocity|effort)\[[^\]]+\]$")
OUTPUT = "is this controller output the drive signal? if it is a current, move the line to current"
LOAD_SIDE = (
    "is this the torque or force of the drive, or of a sensor at the load? the channel "
    "effort is the effort of the drive"
)


@dataclass(frozen=True)
class OfferedColumn:
    """Column of a file that may become a channel.

    name: name of the column.
    table: table with the column.
    preset: entry for the column in the preset of the log (logger_presets.py); None if there is no
        such entry.
    """

    name: str
    table: MemoryTable
    preset: PresetColumn | None = None

    @property
    def unit(self) -> str | None:
        """Return the unit in the file, in the preset or at the end of the name; None if unknown."""
        given = self.table.units.get(self.name)
        if given or self.preset is None:
            return given or unit_in(self.name)
        unit = self.preset.unit_of(self.values)
        return None if unit == OPEN else unit

    @property
    def values(self) -> Vector:
        """Return the column's values (n,)."""
        return self.table.columns[self.name]

    @property
    def unitless(self) -> bool:
        """Return True if the column has no unit, or is a share of an unknown full scale."""
        return self.unit in (None, PERCENT)


@dataclass(frozen=True)
class ColumnChoice:
    """Column and unit chosen for a channel.

    column: name of the chosen column; OPEN if `questions` asks the user for the column.
    unit: chosen unit; OPEN if `questions` asks the user for the unit.
    columns: columns that fit the channel equally well.
    table: table that contains the first of these columns.
    questions: questions to the user about the column and the unit.
    """

    column: str
    unit: str
    table: MemoryTable
    columns: tuple[str, ...]
    questions: tuple[ColumnQuestion, ...] = field(default=())


def dimension_of(channel: str) -> str:
    """Return the dimension of a channel or of `time`, as a key for unit conversions."""
    return CHANNEL_DIMENSIONS.get(channel, TIME)


def is_count(unit: str) -> bool:
    """Return True if a unit means encoder counts."""
    return unit.lower() in COUNTS


def fits(unit: str, dimension: str, axis: Axis) -> bool:
    """Return True if `unit` is a unit of `dimension` for this kind of axis."""
    if is_count(unit):
        return dimension == "position"
    try:
        unit_scale(unit, dimension, axis)
    except ValueError:
        return False
    return True


def names_motion(unit: str, axis: Axis) -> bool:
    """Return True if `unit` is a unit of position or velocity for this kind of axis."""
    return any(fits(unit, kind, axis) for kind in MOTION)


def choose(offered: Sequence[OfferedColumn], axis: Axis) -> dict[str, ColumnChoice]:
    """Return the choice for each channel that at least one column fits; the keys are channels."""
    fitting: dict[str, list[tuple[int, OfferedColumn]]] = {}
    neutral = NEUTRAL.union(*(words(one.name) for one in offered if _names_position(one)))
    for one in offered:
        channels, rank = _channels(one, axis, neutral)
        for channel in channels:
            # the times that the file gives are more exact than a time column
            dated = channel == TIME and one.table.time_ns is not None
            if not dated:
                fitting.setdefault(channel, []).append((rank, one))
    moving = Counter(_label(one.name) for one in offered if changes(one.values))
    chosen: dict[str, ColumnChoice] = {}
    for channel in sorted(fitting, key=CHANNELS.index):
        ranked = fitting[channel]
        best = min(rank for rank, _ in ranked)
        contenders = [one for rank, one in ranked if rank == best]
        most = moving[_label(contenders[0].name)]  # columns of the joint that moves most come first
        equal = [one for one in contenders if moving[_label(one.name)] == most]
        choice = _choice(channel, equal, axis)
        if not _unneeded(channel, choice, chosen):
            chosen[channel] = choice
    if "position" not in chosen and "velocity" not in chosen:
        doubted = {
            drive: _doubted(drive, chosen[drive])
            for drive in DRIVES
            if drive in chosen and chosen[drive].column != OPEN
        }
        if chosen.keys() & {"reference", *DRIVES}:
            chosen = chosen | _unknown_position(offered, axis)
        chosen = chosen | doubted
        return {channel: chosen[channel] for channel in sorted(chosen, key=CHANNELS.index)}
    return chosen


def _unknown_position(offered: Sequence[OfferedColumn], axis: Axis) -> dict[str, ColumnChoice]:
    """Return an open choice for the position if a column with an unknown name changes.

    The result is {} if no such column changes, or if the log has a preset.
    """
    unknown = [
        one
        for one in offered
        if clarity(one.name) == len(QUANTITIES)
        and not is_no_signal(one.name)
        and not is_command(one.name)
        and one.unitless
        and changes(one.values)
    ]
    if not unknown or any(one.preset is not None for one in offered):
        return {}
    names = _quoted([one.name for one in unknown])
    questions = (
        ColumnQuestion("position", "column", names, "no name or unit denotes a position"),
        ColumnQuestion("position", "unit", _candidates("position", axis), "the unit is unknown"),
    )
    return {"position": ColumnChoice(OPEN, OPEN, unknown[0].table, (), questions)}


def _unneeded(channel: str, choice: ColumnChoice, chosen: Mapping[str, ColumnChoice]) -> bool:
    """Return True if a channel can be left out, so that the user need not answer a question.

    A channel `effort` is needed only if the file has neither current nor voltage. The output of a
    controller is needed only if the file has no current. A temperature is never needed.
    """
    if any(question.why == OUTPUT for question in choice.questions):
        return "current" in chosen
    if channel == EFFORT:
        return choice.column == OPEN and any(name in chosen for name in DRIVES)
    return channel == TEMPERATURE and bool(choice.questions)


def _doubted(channel: str, choice: ColumnChoice) -> ColumnChoice:
    """Return the choice with an additional question about the drive signal.

    A log without motion cannot confirm that the signal is the effort of the drive.
    """
    question = ColumnQuestion(
        channel,
        "column",
        _quoted((choice.column,)),
        "is this the drive's effort? no column is a known position or velocity",
    )
    return replace(choice, column=OPEN, questions=(*choice.questions, question))


def changes(values: Vector) -> bool:
    """Return True if the finite numbers in a column (n,) are not all equal."""
    return bool(np.ptp(values[np.isfinite(values)]) > 0.0)


def _label(name: str) -> str:
    match = LABEL.search(name)
    return match[1] if match else ""


def _names_position(one: OfferedColumn) -> bool:
    return quantities(one.name) == ["position"] and not is_command(one.name)


def _channels(one: OfferedColumn, axis: Axis, neutral: Set[str]) -> tuple[list[str], int]:
    """Return the channels that a column fits, and the rank of its name (`clarity`).

    neutral: words such as `axis`, which the name of a position command may contain.
    """
    if one.preset is not None:
        return [one.preset.channel] if one.preset.channel != NO_CHANNEL else [], 0
    if is_no_signal(one.name):
        return [], len(QUANTITIES)
    compatible = [
        name
        for name in dict.fromkeys((*CHANNEL_DIMENSIONS, TIME))
        if name not in SERVO_CHANNELS
        and (one.unit is None or _fits_unit(one.unit, dimension_of(name), axis))
    ]
    named = quantities(one.name)
    if is_command(one.name):
        wanted = {"position": "reference", "current": "current_command", "voltage": "voltage"}
        matching = [wanted[name] for name in named if name in wanted and wanted[name] in compatible]
        commands = "reference" in compatible and _commands_motion(one, axis, neutral)
        of_position = ["reference"] if commands and not named else []
        return matching or of_position, clarity(one.name)
    if named == ["position"] and _counts_rows(one):
        named = [TIME]
    matching = [name for name in named if name in compatible]
    contradicted = bool(named) and clarity(one.name) < CLEAR
    if (
        matching
        or one.unitless
        or contradicted
        or (clarity(one.name) < len(QUANTITIES) and not named)
    ):
        return matching, clarity(one.name) if len(matching) == 1 else len(QUANTITIES)
    by_unit = [name for name in compatible if name not in ("reference", "current_command")]
    return by_unit if len(by_unit) == 1 else [], len(QUANTITIES)


def _commands_motion(one: OfferedColumn, axis: Axis, neutral: Set[str]) -> bool:
    plain = all(is_command(w) or w in neutral or w in UNITS for w in words(one.name))
    return plain and (one.unitless or names_motion(str(one.unit), axis))


def _fits_unit(unit: str, dimension: str, axis: Axis) -> bool:
    return dimension not in SCALED if unit == PERCENT else fits(unit, dimension, axis)


def _choice(channel: str, contenders: Sequence[OfferedColumn], axis: Axis) -> ColumnChoice:
    first = contenders[0]
    # an instrument may repeat its times before each channel; a logger may write a column twice
    contenders = [
        one
        for index, one in enumerate(contenders)
        if not any(_repeats(one, other, channel) for other in contenders[:index])
    ]
    names = tuple(one.name for one in contenders)
    why = "several columns fit equally well" if len(names) > 1 else _doubt(channel, first)
    questions = [] if why is None else [ColumnQuestion(channel, "column", _quoted(names), why)]
    column = first.name if why is None else OPEN
    if first.unit == PERCENT:
        unit = OPEN
        questions += _full_scale_questions(channel, first, axis)
    else:
        unit, unit_question = _unit(channel, first, axis)
        questions += [] if unit_question is None else [unit_question]
    return ColumnChoice(column, unit, first.table, names, tuple(questions))


def _full_scale_questions(channel: str, one: OfferedColumn, axis: Axis) -> list[ColumnQuestion]:
    """Return the questions on unit and scale of a column in per cent of its full scale."""
    dimension = dimension_of(channel)
    units = tuple(unit for unit in _candidates(dimension, axis) if unit != COUNT)
    full = "travel" if dimension == "position" else f"rated {dimension}"
    return [
        ColumnQuestion(channel, "unit", units, f"{one.name!r} is in %"),
        ColumnQuestion(channel, "scale", (f"{full}/100",), f"100 % means the {full}, in this unit"),
    ]


def _candidates(dimension: str, axis: Axis) -> tuple[str, ...]:
    return tuple(CANDIDATES[dimension][axis == "linear"].split(", "))


def _doubt(channel: str, one: OfferedColumn) -> str | None:
    named = quantities(one.name)
    if len(named) > 1 and one.unit is None and one.preset is None:
        return f"its name says {' or '.join(named)}; move the line to the right channel"
    if is_connector(one.name):
        return "is this the signal? its name denotes only a connector of the instrument"
    if channel == "voltage" and one.unitless and clarity(one.name) == PROCESS:
        return OUTPUT
    if channel == "voltage" and one.preset is None and "input" in words(one.name):
        return "is this the voltage of the motor, or the supply?"
    if channel == "reference" and one.unit is None and not named:
        return "is this the reference of the position?"
    rated = one.unit == PERCENT  # a drive states its torque in per cent of the rated torque
    if (
        channel == EFFORT
        and not rated
        and one.name != EFFORT
        and not _JOINT_STATE.fullmatch(one.name)
    ):
        return LOAD_SIDE
    return None


def _unit(channel: str, one: OfferedColumn, axis: Axis) -> tuple[str, ColumnQuestion | None]:
    if one.unit is not None:
        return (COUNT if is_count(one.unit) else one.unit), None
    dimension = dimension_of(channel)
    values = one.values
    if _JOINT_STATE.fullmatch(one.name):
        return si_unit(dimension, axis), None
    why = f"the log states no unit of {one.name!r}"
    if one.preset is not None:
        asked = f"{why}; {one.preset.why}"
        return OPEN, ColumnQuestion(channel, "unit", _candidates(dimension, axis), asked)
    if channel == TIME:
        steps = np.diff(values)
        interval = float(np.median(steps)) if steps.size else 0.0
        if SECONDS[0] <= interval <= SECONDS[1] and TIME in quantities(one.name):
            return "s", None
        why += f"; its steps are {interval:.6g}; if it counts samples, remove the key time"
    if (
        dimension == "position"
        and re.search(r"enc|count|tick", one.name.lower())
        and np.array_equal(values, np.rint(values))
    ):
        return COUNT, None
    step = encoder_step(values) if dimension == "position" else None
    why += "" if step is None else f"; its steps are multiples of {step:.6g}"
    return OPEN, ColumnQuestion(channel, "unit", _candidates(dimension, axis), why)


def _repeats(one: OfferedColumn, other: OfferedColumn, channel: str) -> bool:
    """Return True if two columns have equal names and values; for times, equal values suffice."""
    named = channel == TIME or without_number(one.name) == without_number(other.name)
    return named and np.array_equal(one.values, other.values, equal_nan=True)


def _counts_rows(one: OfferedColumn) -> bool:
    """Return True if a column `x` without a unit increases in equal steps, like a row number."""
    if one.unit is not None or one.name.lower() != "x" or one.values.size < FEWEST_STEPS:
        return False
    steps = np.diff(one.values)
    return bool(steps.min() > 0.0 and np.ptp(steps) <= STEP_TOLERANCE * steps.max())


def _quoted(names: Sequence[str]) -> tuple[str, ...]:
    shown = tuple(repr(name) for name in names)
    return (
        shown
        if len(shown) <= MOST_NAMES
        else (*shown[: MOST_NAMES - 1], f"{len(shown) - MOST_NAMES + 1} more")
    )

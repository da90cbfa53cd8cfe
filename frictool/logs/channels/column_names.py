"""Interpretation of column names: quantity, unit, and whether the column is a command."""

from __future__ import annotations

import re
from collections.abc import Mapping

# levels of clarity; the clearest word decides: "q_current" is a current although q alone is a
# position
QUANTITIES: tuple[dict[str, str], ...] = (
    {"temperature": r"temp|temperature|temperatur"},
    {
        "time": r"time|times|timestamp|timestamps|temps|zeit",
        "voltage": r"voltage|volt|volts|vir|tension|spannung",
        "current": r"current|currents|cur|curr|amp|amps|ampere|iq|courant|strom",
        "velocity": r"velocity|velocities|vel|speed|omega|rpm|qd|dq|gyro|vitesse|drehzahl",
        "effort": r"effort|torque|force|tau|couple|drehmoment|kraft",
        "position": r"position|positions|pos|angle|theta|displacement|winkel|qg|qm",
    },
    {"position": r"encoder|enc|counter|count|counts|opening|travel|stellung"},
    {"position": r"pv|sp|sv", "voltage": r"op|mv|cv|lmn"},  # suffixes of a process controller's tag
    {"time": r"t", "voltage": r"u|v", "current": r"i", "position": r"q|x|y"},
)
_COMMAND = re.compile(
    r"ref|reference|setpoint|target|request|requested|desired|des|command|cmd|commanded|goal|demand|"
    r"qg|consigne|soll|sollwert|set|sp|sv"
)
_NO_SIGNAL = re.compile(
    r"error|err|deviation|norm|limit|max|min|bus|vbus|supply|vsupply|bat|batt|vbat|battery|vdc|inp|"
    r"fehler|schleppfehler|erreur|lag"
)
PERCENT = "%"  # unit of a share of the full scale
UNITS: Mapping[str, str] = {  # units that may end a name
    "s": "s", "sec": "s", "seconds": "s", "ms": "ms", "us": "us", "ns": "ns",
    "rad": "rad", "radians": "rad", "deg": "deg", "degrees": "deg", "turns": "turn", "revs": "turn",
    "rpm": "rpm", "mm": "mm", "nm": "N m",
    "radps": "rad/s", "degps": "deg/s", "dps": "deg/s", "mps": "m/s", "mmps": "mm/s",
    "a": "A", "amp": "A", "amps": "A", "ampere": "A", "ma": "mA", "v": "V", "volt": "V",
    "volts": "V", "mv": "mV",
    "count": "count", "counts": "count", "ticks": "count",
    "degc": "degC", "celsius": "degC", "kelvin": "K",
}  # fmt: skip
RATES: Mapping[tuple[str, str], str] = {
    ("rad", "s"): "rad/s", ("deg", "s"): "deg/s", ("mm", "s"): "mm/s", ("m", "s"): "m/s",
    ("rev", "s"): "turn/s", ("turns", "s"): "turn/s",
}  # fmt: skip
# units that may instead be the label of a phase or input, and the quantities of these units
LABELS: Mapping[str, str] = {"a": "current", "v": "voltage"}
# names of inputs of an instrument, which do not say what signal is connected
_CONNECTOR = re.compile(
    r"((ch|chn|channel|kanal|ai|analog|analogue|input|trace|untitled|dev\d+/ai)[ _]*\d{0,2}[a-d]?"
    r"|voltage[ _]*\d{1,2})( \(column \d+\))?",
    re.IGNORECASE,
)
_NUMBER = re.compile(r" \(column \d+\)$")  # added to a name that several columns have
# supply voltage in a name such as voltage5V or 3V3
_RAIL = re.compile(r"(?<!\d)\d{1,2}v(\d|(?![a-z]))", re.IGNORECASE)
_HUMP = re.compile(r"(?<=[a-z])(?=[A-Z])")  # word boundary in a name such as motorCurrent


def words(name: str) -> list[str]:
    """Return the words of a name in lower case.

    >>> words("motorCurrent_q2")
    ['motor', 'current', 'q']
    """
    return [word for word in re.split(r"[^a-z]+", _HUMP.sub(" ", name).lower()) if word]


def quantities(name: str) -> list[str]:
    """Return the channels that the clearest word of a column name may denote.

    The result is empty if no word denotes a channel. The result has several channels if the word is
    ambiguous.

    >>> quantities("q_current"), quantities("TorqueCur")
    (['current'], ['current', 'effort'])
    >>> quantities("i_q"), quantities("bus_voltage"), quantities("current_sensor_temp")
    (['current'], [], ['temperature'])
    >>> quantities("voltage5V_v"), quantities("V101.PV")
    ([], ['position'])
    """
    if is_no_signal(name):
        return []
    name_words = set(words(name))
    name_words.add("".join(words(name)))
    for level in QUANTITIES:
        fitting = [
            channel for channel, pattern in level.items() if name_words & set(pattern.split("|"))
        ]
        if fitting:
            return fitting
    return []


def clarity(name: str) -> int:
    """Return the rank of a column name; 0 is the clearest name.

    A name that denotes no channel has the rank len(QUANTITIES).
    """
    name_words = {*words(name), "".join(words(name))}
    levels = (set("|".join(level.values()).split("|")) for level in QUANTITIES)
    return next(
        (number for number, level in enumerate(levels) if name_words & level), len(QUANTITIES)
    )


def is_no_signal(name: str) -> bool:
    """Return True if a name denotes a supply, a limit or an error instead of a channel.

    >>> is_no_signal("Ori_err_norm_rad"), is_no_signal("3V3"), is_no_signal("angle")
    (True, True, False)
    """
    return any(map(_NO_SIGNAL.fullmatch, words(name))) or _RAIL.search(name) is not None


def is_command(name: str) -> bool:
    """Return True if a column name denotes a command instead of a measurement.

    >>> is_command("PosSet"), is_command("FV101.SP"), is_command("PosAct")
    (True, True, False)
    """
    return any(map(_COMMAND.fullmatch, words(name)))


def without_number(name: str) -> str:
    """Return a name without the number that was appended to make it unique.

    >>> without_number("target_q_0 (column 26)")
    'target_q_0'
    """
    return _NUMBER.sub("", name)


def is_connector(name: str) -> bool:
    """Return True if a name denotes a connector of an instrument instead of a signal.

    >>> is_connector("CH1"), is_connector("Channel B"), is_connector("current")
    (True, True, False)
    """
    return _CONNECTOR.fullmatch(name) is not None


def unit_in(name: str) -> str | None:
    """Return the unit at the end of a column name; None if the name ends in no unit.

    >>> unit_in("measured_velocity_deg_s"), unit_in("timestamp_ms")
    ('deg/s', 'ms')
    >>> unit_in("torque_Nm"), unit_in("pos_estimate"), unit_in("gyro_z_radps")
    ('N m', None, 'rad/s')

    >>> unit_in("SP %")
    '%'

    A name of a single word is a unit only if it is rpm, amps, volts, counts or ticks. A single A or
    V is a unit only after the name of a current or voltage. Otherwise it is a label.

    >>> unit_in("motor_current_A"), unit_in("Phase A")
    ('A', None)
    """
    if name.endswith(PERCENT):
        return PERCENT
    parts = [part.lower() for part in re.split(r"[^A-Za-z]+", name) if part]
    if len(parts) > 2 and (parts[-2], parts[-1]) in RATES:
        return RATES[parts[-2], parts[-1]]
    label = LABELS.get(parts[-1]) if parts else None
    if label is not None and label not in quantities(" ".join(words(name)[:-1])):
        return None
    return (
        UNITS.get(parts[-1])
        if len(parts) > 1 or parts[-1:] in (["rpm"], ["amps"], ["volts"], ["counts"], ["ticks"])
        else None
    )

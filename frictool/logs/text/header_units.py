"""Recognition of units in the headers of instruments, and their spelling in the units library."""

from __future__ import annotations

import re

ISO_8601 = "iso8601"  # unit of a column of dates and times of day
SPELLED = {  # spellings that the units library does not read or reads differently
    "sec": "s", "secs": "s", "second": "s", "seconds": "s", "msec": "ms", "usec": "us",
    "µsec": "us", "nsec": "ns",
    "newton": "N", "newtons": "N", "radian": "rad", "radians": "rad", "degrees": "deg",
    "volt": "V", "volts": "V", "amp": "A", "amps": "A", "ampere": "A", "amperes": "A",
    "r/min": "rpm", "rev/min": "rpm", "1/min": "rpm", "min-1": "rpm", "min^-1": "rpm",
    "u/min": "rpm", "tr/min": "rpm", "giri/min": "rpm", "upm": "rpm",
    "umdr/min": "rpm", "umdr./min": "rpm", "umdrehungen/min": "rpm",
    "umdr": "turn", "umdr.": "turn", "umdrehungen": "turn", "tours": "turn", "giri": "turn",
    "gradi": "deg", "grados": "deg", "degré": "deg", "degrés": "deg",
    "sek": "s", "sekunden": "s", "secondes": "s", "secondi": "s", "segundos": "s",
    "newtonmeter": "N m", "millimeter": "mm", "millimètres": "mm",
    "pulse": "count", "pulses": "count", "counts": "count", "cnt": "count", "cts": "count",
    "inc": "count", "ticks": "count",
    "nm": "N m", "n.m": "N m", "n*m": "N m", "mnm": "mN m", "ncm": "N cm", "knm": "kN m",
    "percent": "%", "pct": "%", "prozent": "%", "pourcent": "%",
    "°": "deg", "°/s": "deg/s", "degc": "degC", "°c": "degC",
}  # fmt: skip
NO_UNIT = ("", "-", "--", "none", "(none)", "n/a", "unit", "units", "einheit", "unité")
_PART = re.compile(
    r"(?:[munpkMGcd\u00b5\u03bc])?(?:s|V|A|N|m|g|W|J|Hz|Pa|bar|rad|T)(?:\^?-?\d|²|³)?|min|h|deg|"
    r"°|rpm|rev|turn|count|degC|K|%|in|ft|lbf|1"
)
_GERMAN_DEGREES = re.compile(r"\bGrad\b")  # the units library reads `Grad` as giga-radians
_BRACKETED = re.compile(r"\s*[\[(]([^\[\]()]*)[\])]\s*")
_IN_BRACKETS = re.compile(r"(.*?)\s*\[([^\[\]]*)\]")
_IN_PARENTHESES = re.compile(r"(.*\S)\s*\(([^()]*)\)")
_AFTER_SLASH = re.compile(r"([^/]*\S)\s*/\s*(\S+)")


def spelled(text: str) -> str | None:
    """Return the unit `text` in the spelling of the units library; None if it is not a unit.

    >>> spelled("[r/min]"), spelled("VOLT"), spelled(" - ")
    ('rpm', 'V', None)
    >>> spelled("[Grad/s]"), spelled("Umdr./min")
    ('deg/s', 'rpm')
    """
    match = _BRACKETED.fullmatch(text)
    unit = (match.group(1) if match else text).strip().strip("-").strip()
    if unit.lower() in NO_UNIT:
        return None
    unit = _GERMAN_DEGREES.sub("deg", unit)
    return SPELLED.get(unit.lower(), unit.replace("\u00b5", "u").replace("\u03bc", "u"))


def is_unit(text: str) -> bool:
    """Return True if a cell of a header is a unit and not a name.

    >>> is_unit("m/s"), is_unit("(mN m)"), is_unit("Force"), is_unit("Volt")
    (True, True, False, True)
    """
    unit = spelled(text)
    if unit is None:
        return False
    return unit in SPELLED.values() or all(
        _PART.fullmatch(part) for part in re.split(r"[\s/*.·]+", unit)
    )


def _ends_in_unit(name: str) -> bool:
    last = name.split()[-1]
    return is_unit(last) and not last.isdigit()


def name_and_unit(cell: str) -> tuple[str, str | None]:
    """Return name and unit of a header cell: `speed [rpm]`, `speed (rpm)` or `speed/rpm`.

    A text in brackets is a unit. A text in parentheses or after a slash is a unit only if `is_unit`
    recognises it and the text before it does not end in a unit. A whole number is an index, as in
    `q[0]` and `pos (1)`.

    >>> name_and_unit("speed (r/min)"), name_and_unit("torque (filtered)"), name_and_unit("U/V")
    (('speed', 'rpm'), ('torque (filtered)', None), ('U', 'V'))
    >>> name_and_unit("pos (1)")
    ('pos (1)', None)
    """
    match = _IN_BRACKETS.fullmatch(cell)
    if match and not match.group(2).strip().isdigit():
        return match.group(1), spelled(match.group(2))
    for form in (_IN_PARENTHESES, _AFTER_SLASH):
        match = form.fullmatch(cell)
        numbered = match is not None and match.group(2).strip().isdigit()  # such as `pos (1)`
        if match and not numbered and is_unit(match.group(2)) and not _ends_in_unit(match.group(1)):
            return match.group(1), spelled(match.group(2))
    return cell, None

"""Units as the headers of instruments write them: told from names, and spelled as the units library
reads them."""

from __future__ import annotations

import re

ISO_8601 = "iso8601"  # the unit of a column of dates and times of day
SPELLED = {  # what the units library does not read, or reads as something else
    "sec": "s", "secs": "s", "second": "s", "seconds": "s", "msec": "ms", "usec": "us", "µsec": "us", "nsec": "ns",
    "volt": "V", "volts": "V", "amp": "A", "amps": "A", "ampere": "A", "amperes": "A",
    "r/min": "rpm", "rev/min": "rpm", "1/min": "rpm", "min-1": "rpm", "min^-1": "rpm", "u/min": "rpm", "tr/min": "rpm",
    "pulse": "count", "pulses": "count", "counts": "count", "cnt": "count", "cts": "count", "inc": "count", "ticks": "count",
    "nm": "N m", "n.m": "N m", "n*m": "N m", "mnm": "mN m", "ncm": "N cm", "knm": "kN m",
    "°": "deg", "°/s": "deg/s", "degc": "degC", "°c": "degC",
}  # fmt: skip
NO_UNIT = ("", "-", "--", "none", "(none)", "n/a", "unit", "units", "einheit", "unité")
_PART = re.compile(
    r"(?:[munpkMGcd\u00b5\u03bc])?(?:s|V|A|N|m|g|W|J|Hz|Pa|bar|rad|T)(?:\^?-?\d|²|³)?|min|h|deg|°|rpm|rev|turn|count|degC|K|%|in|ft|lbf|1"
)
_BRACKETED = re.compile(r"\s*[\[(]([^\[\]()]*)[\])]\s*")
_IN_BRACKETS = re.compile(r"(.*?)\s*\[([^\[\]]*)\]")
_IN_PARENTHESES = re.compile(r"(.*\S)\s*\(([^()]*)\)")
_AFTER_SLASH = re.compile(r"([^/]*\S)\s*/\s*(\S+)")


def spelled(text: str) -> str | None:
    """The unit as the units library reads it, or None where there is none.

    >>> spelled("[r/min]"), spelled("VOLT"), spelled(" - ")
    ('rpm', 'V', None)
    """
    match = _BRACKETED.fullmatch(text)
    unit = (match.group(1) if match else text).strip().strip("-").strip()
    if unit.lower() in NO_UNIT:
        return None
    return SPELLED.get(unit.lower(), unit.replace("\u00b5", "u").replace("\u03bc", "u"))


def is_unit(text: str) -> bool:
    """Whether a cell of a header is a unit and not a name.

    >>> is_unit("m/s"), is_unit("(mN m)"), is_unit("Force"), is_unit("Volt")
    (True, True, False, True)
    """
    unit = spelled(text)
    if unit is None:
        return False
    return unit in SPELLED.values() or all(
        _PART.fullmatch(part) for part in re.split(r"[\s/*.·]+", unit)
    )


def name_and_unit(cell: str) -> tuple[str, str | None]:
    """A header's cell parted: `speed [rpm]`, `speed (rpm)`, `speed/rpm`; brackets hold a unit
    always, the others where it is one.

    >>> name_and_unit("speed (r/min)"), name_and_unit("torque (filtered)"), name_and_unit("U/V")
    (('speed', 'rpm'), ('torque (filtered)', None), ('U', 'V'))
    """
    match = _IN_BRACKETS.fullmatch(cell)
    if match:
        return match.group(1), spelled(match.group(2))
    for form in (_IN_PARENTHESES, _AFTER_SLASH):
        match = form.fullmatch(cell)
        if match and is_unit(match.group(2)) and not is_unit(match.group(1).split()[-1]):
            return match.group(1), spelled(match.group(2))
    return cell, None

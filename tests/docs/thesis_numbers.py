"""Last numbers of the thesis's equations, figures, tables and sections."""

from __future__ import annotations

LAST_EQUATION = {"2": 51, "3": 63, "4": 45, "5": 71, "6": 26}
LAST_FIGURE = {"2": 18, "3": 25, "4": 17, "5": 33, "6": 10, "C": 13}  # C: of annex C
LAST_TABLE = {"2": 1, "3": 2, "4": 8, "5": 3}
_PARTS = (
    "2.1:6 2.2:5 2.3:2 2.3.2:4 2.4:4 2.4.2:4 2.4.3:5 3.4:3 3.4.1:4 3.4.2:3 3.7:6 4.2:6 4.2.1:1 "
    "4.2.5:4 4.2.6:2 4.4:4 4.4.2:2 "
    "5.2:6 5.3:4 5.4:4 5.4.3:3 5.4.4:3 6.3:2 6.4:2"
)
LAST_SECTION = {
    whole: int(last) for whole, _, last in (part.partition(":") for part in _PARTS.split())
}  # of the sections that have parts


def is_there(number: str, last: dict[str, int]) -> bool:
    """Return True if the thesis has an equation, figure, table or section of this number, as "5.71"
    or "4.2.5.4"."""
    whole, _, part = number.rpartition(".")
    return 1 <= int(part) <= last.get(whole, 0)


def numbers(last: dict[str, int]) -> list[str]:
    """All that there are, in order."""
    return [f"{whole}.{part}" for whole, most in last.items() for part in range(1, most + 1)]

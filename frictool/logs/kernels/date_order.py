"""Possible orders of the parts of a date: year, day or month first."""

YEAR_FIRST, DAY_FIRST, MONTH_FIRST = 0, 1, 2

"""Order of the parts of a date: the year first only, or also the day or the month first."""

YEAR_FIRST, DAY_FIRST, MONTH_FIRST = 0, 1, 2

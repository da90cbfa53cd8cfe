"""Reports of logs whose truth is known: limit cycles of table 5.1's loops, and loads behind a
backlash."""

from __future__ import annotations

import functools

from studies.table_5_1.published_figures import LOOPS
from tests.support.reported_logs import limit_cycle, load_behind_the_backlash

CHECKS = {
    **{f"report: limit cycle of {name}": functools.partial(limit_cycle, name) for name in LOOPS},
    "report: bounds of the load": load_behind_the_backlash,
}

"""Table 5.1's loops over holds of 600 s, as the product plays them: overshoot, response, static
error and limit cycle within 2 % of what is known of them.

    python -m tests.accept build/accept.json table_5_1_pid table_5_1_pid_limiter ...

A figure farther than 2 % off passes only if it is the printed number once rounded as that is;
`rounded` names those, `missed` the others.
"""

from __future__ import annotations

import functools
import math
from typing import Any

from studies.table_5_1.product_loops import played
from studies.table_5_1.published_figures import (
    FIGURES,
    LOOPS,
    TOLERANCE,
    deviation,
    figures,
    missed,
)

SECONDS = 600.0


def loop_figures(name: str) -> dict[str, Any]:
    """The figures of one loop, null where it never settles or nothing recurs, and how far they are
    from the print [%]."""
    loop = LOOPS[name]
    found = figures(played(name, SECONDS))
    away = {
        figure: deviation(found[figure], printed)
        for figure, printed in zip(FIGURES, loop.printed, strict=True)
    }
    beyond, wrong = (
        [figure for figure in FIGURES if abs(away[figure]) > TOLERANCE],
        missed(found, loop.printed),
    )
    shown = {figure: value if math.isfinite(value) else None for figure, value in found.items()}
    return {
        "passed": not wrong,
        **shown,
        "printed": dict(zip(FIGURES, loop.printed, strict=True)),
        "deviation_percent": {
            figure: 100.0 * value if math.isfinite(value) else None
            for figure, value in away.items()
        },
        "rounded": [figure for figure in beyond if figure not in wrong],
        "missed": wrong,
    }


CHECKS = {f"table_5_1_{name}": functools.partial(loop_figures, name) for name in LOOPS}

"""Table of variants of the wear estimator: windows, and priors of friction over speed.

    python -m studies.observers.wear_variants [SEEDS]

prints the rms and the largest error [%] after 8 moves and after 20 s, and the coverage of the 95 %
intervals. The plants are random, without and with viscous friction that the model does not include.
The seeds from 5000 on are those with which the estimator was tuned; no acceptance check uses them.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frictool.observe.motion_block import MotionBlock
from frictool.observe.wear.filter_bank import UNMODELLED, FilterBank
from frictool.observe.wear.log_moves import MoveCollector
from frictool.observe.wear.parameter_restriction import UnmodelledFriction, multiplicative
from frictool.observe.wear.weak_form_layout import WeakFormLayout, layout_of
from frictool.observe.wear.wear_estimator import ADDS_UP, FIRST_NOISE, WALK
from studies.observers.wear_runs import LOOPS, SOON, drawn, reference
from studies.rigs.clutch_fleet import Unit, believed, run

FIRST, SEEDS = 5000, 30
VISCOUS = 1e-4  # N m s/rad, a third of the dry friction at top speed
WINDOWS = (25, 35, 45, 57)
NONE, OPEN = (
    (UNMODELLED[0],) * len(UNMODELLED),
    (UnmodelledFriction(0.0, 0.3, 0.3),) * len(UNMODELLED),
)
VARIANTS: dict[str, tuple[int | None, Sequence[UnmodelledFriction]]] = {
    "as it is": (None, UNMODELLED),
    **{f"window of {window}": (window, UNMODELLED) for window in WINDOWS},
    "friction over speed as the model's": (None, NONE),
    "friction over speed open": (None, OPEN),
}


def bank_of(layout: WeakFormLayout, beside: Sequence[UnmodelledFriction]) -> FilterBank:
    """Return the filter bank of the estimator with other priors of friction over speed."""
    inflation = max(1.0, ADDS_UP / (layout.every * float(layout.phi @ layout.phi)))
    known = [multiplicative(believed(), layout, one) for one in beside]
    return FilterBank(known, (FIRST_NOISE * layout.friction) ** 2, inflation, "wear", WALK)


def errors(
    log: MotionBlock, wear: float, window: int | None, beside: Sequence[UnmodelledFriction]
) -> list[float]:
    """Return error and standard deviation of the wear [%] after SOON moves and at the end."""
    layout, out = layout_of(believed(), window=window), [0.0] * 4
    moves, bank = MoveCollector(layout), bank_of(layout, beside)
    for count, move in enumerate([*moves.take(log), *moves.end()], start=1):
        bank.take(move)
        value, deviation = bank.value("wear")
        out[2:] = 100.0 * (value / wear - 1.0), 100.0 * deviation / wear
        if count <= SOON:
            out[:2] = out[2:]
    return out


def logs(seeds: Sequence[int], viscous: float) -> list[tuple[Unit, MotionBlock]]:
    """Return the logs of the second test under both loops."""
    units = [(replace(drawn(seed), plain_viscous=viscous), seed) for seed in seeds]
    return [
        (unit, run(unit, reference(seed), seed, loop).pieces[0])
        for loop in LOOPS
        for unit, seed in units
    ]


def main(arguments: list[str]) -> int:
    seeds = range(FIRST, FIRST + (int(arguments[0]) if arguments else SEEDS))
    print(f"{'':36}{'8 moves':>17}{'20 s':>17}      intervals hold")
    for plants, viscous in (("spread", 0.0), ("and viscous", VISCOUS)):
        given = logs(seeds, viscous)
        for name, (window, beside) in VARIANTS.items():
            found = np.array([errors(log, unit.wear, window, beside) for unit, log in given])
            shown = [
                f"{np.sqrt(np.mean(found[:, k] ** 2)):8.2f} {np.max(np.abs(found[:, k])):8.2f}"
                for k in (0, 2)
            ]
            held = [
                f"{np.mean(np.abs(found[:, k]) <= 1.96 * found[:, k + 1]):6.2f}" for k in (0, 2)
            ]
            print(f"{name + ', ' + plants:48.48s}{''.join(shown)}  {' '.join(held)}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

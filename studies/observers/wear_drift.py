"""Coverage of the wear's intervals while wear grows.

    python -m studies.observers.wear_drift

In each row, the wear grows at one rate over 20 pieces of two moves each. The columns are the share
of the 95 % intervals that contain the true wear, their median half width, and the rms error without
the first 8 estimates. The axis moves to random targets, in 3 sequences, with the speed controller.
"""

from __future__ import annotations

import numpy as np

from frictool.observe.wear.wear_estimator import WearEstimator
from studies.rigs.clutch_fleet import Unit, clutch, run, targets

PIECES, SETTLED = 20, 8


def main() -> None:
    print("a move      held   half width   rms error")
    for step in (0.0002, 0.002, 0.01, 0.025):
        held, half, errors = [], [], []
        for sequence in (0, 100, 200):
            estimator, ratios = WearEstimator(clutch()), []
            for part in range(PIECES):
                wear = 1.0 + step * part
                for one in estimator.take(
                    run(
                        Unit(wear=wear), targets(sequence + part, 1.0), sequence + part, "speed"
                    ).pieces[0]
                ):
                    held.append(one.wear.low <= wear <= one.wear.high)
                    half.append(0.5 * (one.wear.high - one.wear.low) / wear)
                    ratios.append(one.wear.value / wear - 1.0)
            errors += ratios[SETTLED:]
        print(
            f"{50 * step:6.3g} %   {np.mean(held):6.1%}   {np.median(half):10.2%}   "
            f"{np.sqrt(np.mean(np.square(errors))):9.2%}"
        )


if __name__ == "__main__":
    main()

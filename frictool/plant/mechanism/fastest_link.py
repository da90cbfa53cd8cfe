"""Highest rate of an oscillation or decay at a compliant link, which limits the step size."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictool.plant.mechanism.assembled_mechanism import AssembledMechanism
from frictool.plant.mechanism.packed_mechanism import FRAME


class FastestLink(NamedTuple):
    """Compliant link with the highest `rate` [1/s]; the rate is 0 if no link is compliant.

    The rate is the larger of sqrt(k/m) and d/m, with the link's stiffness k and damping d, and the
    reduced mass m of the inertias at its two ends (`fastest_link`).
    """

    rate: float
    link: str


def fastest_link(assembled: AssembledMechanism) -> FastestLink:
    """Return the compliant link with the highest rate.

    The reduced mass m of a link is given by 1/m = 1/m_1 + 1/m_2, with the inertias m_1 and m_2 of
    its ends referred to the second end. The inertia of an end includes rigidly linked blocks.
    """
    mobility = np.zeros(len(assembled.blocks))
    for group in assembled.groups:
        for block, ratio in zip(group.blocks, group.ratios, strict=True):
            mobility[block] = ratio * ratio / group.inertia if group.inertia > 0.0 else math.inf
    couplings = assembled.packed.couplings
    fastest = FastestLink(0.0, "")
    for link, name in enumerate(assembled.couplings):
        a, b = int(couplings.a[link]), int(couplings.b[link])
        moved = mobility[b] + (0.0 if a == FRAME else couplings.ratio[link] ** 2 * mobility[a])
        rate = max(
            math.sqrt(couplings.stiffness[link] * moved), float(couplings.damping[link] * moved)
        )
        if math.isfinite(rate) and rate > fastest.rate:
            fastest = FastestLink(rate, name)
    return fastest

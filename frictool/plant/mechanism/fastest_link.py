"""Rates of compliant links, which limit the step size, and the damping that limits these rates."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictool.plant.mechanism.assembled_mechanism import AssembledMechanism
from frictool.plant.mechanism.packed_mechanism import FRAME, Couplings
from frictool.typing import Vector

# rad/s, largest rate of a link whose oscillation is simulated; 1 rad takes 5 us
LARGEST_RATE = 2e5


class FastestLink(NamedTuple):
    """Compliant link with the highest `rate` [1/s]; the rate is 0 if no link is compliant.

    `LinkRates` defines the rate.
    """

    rate: float
    link: str


class LinkRates(NamedTuple):
    """Rates and damping of c compliant links; all fields are arrays (c,).

    The reduced mass m of a link is given by 1/m = 1/m_1 + 1/m_2, with the inertias m_1 and m_2 of
    its ends referred to the second end. The inertia of an end includes rigidly linked blocks. A
    link with the stiffness k and the damping d has the rate max(sqrt(k/m), d/m).

    - mobility: 1/m [1/kg | 1/(kg m^2)]
    - rate: rate of the link [1/s]
    - damping: damping in a simulation [N s/m | N m s/rad]
    - raised: True if `damping` is the critical damping 2 sqrt(k m) in place of a smaller d, because
      sqrt(k/m) exceeds LARGEST_RATE and the link has no backlash
    - stiff: True if the rate exceeds LARGEST_RATE and `damping` is at least critical
    """

    mobility: Vector
    rate: Vector
    damping: Vector
    raised: NDArray[np.bool_]
    stiff: NDArray[np.bool_]


def link_rates(couplings: Couplings, mobility: Vector) -> LinkRates:
    """Return the rates of compliant links.

    mobility (n,): reciprocal inertia of each block with all rigidly linked blocks, referred to the
    block [1/kg | 1/(kg m^2)].
    """
    a, b = couplings.a, couplings.b
    moved = mobility[b] + np.where(a == FRAME, 0.0, couplings.ratio**2 * mobility[a])
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        angular = np.sqrt(couplings.stiffness * moved)
        decay = couplings.damping * moved
        critical = 2.0 * np.sqrt(couplings.stiffness / moved)
    rate = np.maximum(angular, decay)
    fast = np.isfinite(rate) & (rate > LARGEST_RATE)
    damped = couplings.damping >= critical
    raised = fast & (angular > LARGEST_RATE) & (couplings.gap == 0.0) & ~damped
    return LinkRates(
        moved,
        rate,
        np.where(raised, critical, couplings.damping),
        raised,
        raised | (fast & damped),
    )


def rates_of(assembled: AssembledMechanism) -> LinkRates:
    """Return the rates of the compliant links of an assembled mechanism."""
    mobility = np.zeros(len(assembled.blocks))
    for group in assembled.groups:
        for block, ratio in zip(group.blocks, group.ratios, strict=True):
            mobility[block] = ratio * ratio / group.inertia if group.inertia > 0.0 else math.inf
    return link_rates(assembled.packed.couplings, mobility)


def fastest_link(assembled: AssembledMechanism, *, explicit: bool = False) -> FastestLink:
    """Return the compliant link with the highest rate.

    explicit: consider only links whose oscillation a simulation resolves (`stiff` is False).
    """
    rates = rates_of(assembled)
    fastest = FastestLink(0.0, "")
    for link, name in enumerate(assembled.couplings):
        if explicit and rates.stiff[link]:
            continue
        rate = float(rates.rate[link])
        if math.isfinite(rate) and rate > fastest.rate:
            fastest = FastestLink(rate, name)
    return fastest

"""Search for the smallest bounds of a loop that can be proved (verify/zero_exclusion.py).

A box contains all plants whose parameters lie in given intervals. The search tries to prove the
bound (1 + slack) N. N is the largest known norm, at first the largest norm at the corners of the
box. If the proof fails at a plant with a larger norm, N becomes this norm. After each failure, the
slack is doubled. If a proof needed more than the smallest slack, SLACK, the search is repeated from
SLACK with the new N, as long as the proved bound falls.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence

import numpy as np

from frictool.adapters.state_space import read_state_space
from frictool.documents.certificate import Bound, Box, Certificate, CertifiedWeights, Filter
from frictool.errors import NoSolutionError
from frictool.plant.generalised_plant import FirstOrderWeight, PlantWeights, generalised_plant
from frictool.plant.parameter_box import corners
from frictool.plant.polytope import PlantPoint
from frictool.presentation.tie_rule import largest
from frictool.verify.certificate_loop import CertificateLoop, Quantity, quantity_loops
from frictool.verify.document_check import check_feedback
from frictool.verify.feedback_loops import chain, speed_feedback
from frictool.verify.loop_values import weights_of
from frictool.verify.proved_bound import ProvedBound
from frictool.verify.speed_loop import performance

SLACK = 0.001  # slack of the first proof
LARGE_SLACK = 0.1  # largest slack if the proofs need too many cells
MOST_SLACK = 1e6  # largest slack if plants violate the bounds


def certify(loop: CertificateLoop, box: Box) -> tuple[Certificate, tuple[ProvedBound, ...]]:
    """Return the certificate of a loop for all plants in `box`, and the bounds that were proved.

    For a bound that is not proved, the certificate contains the reason. Raises NoSolutionError if
    the loop is unstable for a plant of the box.
    """
    found = {of: _proved(quantity_loops(loop, of), box, of) for of in loop.quantities}
    proved = tuple(bound for bound in found.values() if isinstance(bound, ProvedBound))
    return (
        Certificate(
            2,
            box,
            loop.weights,
            tuple(Bound(bound.of, bound.below) for bound in proved),
            {of: reason for of, reason in found.items() if isinstance(reason, str)},
        ),
        proved,
    )


def certified_weights(weights: PlantWeights) -> CertifiedWeights:
    """Return the weights of a design in the form that a certificate stores."""

    def stored(weight: FirstOrderWeight) -> Filter:
        return Filter(
            weight.gain,
            *(value if np.isfinite(value) else None for value in (weight.zero, weight.pole)),
        )

    noise = stored(weights.noise)
    return CertifiedWeights(
        stored(weights.error),
        weights.disturbance,
        weights.drive,
        weights.command,
        noise,
        weights.eta,
    )


def _proved(loops: Sequence[CertificateLoop], box: Box, of: Quantity) -> ProvedBound | str:
    from frictool.verify.zero_exclusion import MOST_CELLS, prove_bounds  # loads numba

    seen = _worst(loops, corners(_ends(box)))
    proved = None
    slack = SLACK
    while True:
        below = float(f"{(1.0 + slack) * seen:.5g}")
        if proved is not None and below >= proved.below:
            return proved
        cells = prove_bounds(loops, box, below)
        if isinstance(cells, int):
            proved = ProvedBound(of, below, cells)
            if slack == SLACK:
                return proved
            slack = SLACK
            continue
        plant = PlantPoint("", cells.inertia, cells.viscous, _coulomb(box), cells.constant)
        seen = max(seen, _worst(loops, [plant]))
        slack *= 2.0
        if slack > (MOST_SLACK if cells.violated else LARGE_SLACK):
            break
    return proved or (
        f"the proof of {of} < {below:.4g} needs more than {MOST_CELLS} cells (largest value seen: "
        f"{seen:.4g}); narrow the intervals of the model or of the bench"
    )


def _worst(loops: Sequence[CertificateLoop], points: Iterable[PlantPoint]) -> float:
    norms = []
    for point, loop in itertools.product(points, loops):
        norms.append(_norm(loop, point))
        if not math.isfinite(norms[-1]):
            raise NoSolutionError(
                f"not verified: the sampled loop is unstable at inertia {point.inertia:.4g}, "
                f"viscous {point.viscous:.4g}, constant {point.constant:.4g}; relax the weights"
            )
    return largest(norms)[0]


def _norm(loop: CertificateLoop, point: PlantPoint) -> float:
    controller = (
        chain(loop.sections, loop.period)
        if loop.sections
        else read_state_space(loop.controller, loop.period)
    )
    if loop.speed is not None:
        feedback = speed_feedback(
            controller, loop.speed.velocity, loop.speed.position_gain, loop.period
        )
        check = check_feedback(feedback, point.rates, loop.lag, loop.delay)
        return 1.0 / check.modulus_margin if check.stable and check.modulus_margin else math.inf
    weights = weights_of(loop.weights)
    return performance(
        controller,
        generalised_plant(loop.controlled, point.rates, loop.lag, weights, loop.period, loop.delay),
    )


def _ends(box: Box) -> dict[str, tuple[float, float]]:
    intervals = {
        "inertia": box.inertia,
        "viscous": box.viscous,
        "coulomb": box.coulomb,
        "constant": box.constant,
    }
    return {name: (low, high) for name, (low, high) in intervals.items()}


def _coulomb(box: Box) -> float:
    return max(abs(end) for end in box.coulomb)

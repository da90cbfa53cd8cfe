"""A mechanism reduced: the chain of steps, intervals, model and check, in one call."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from frictool.documents.bench import Bench
from frictool.documents.key_lines import document_error
from frictool.documents.mechanism import Mechanism
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance, provenance_of_call
from frictool.errors import NoSolutionError
from frictool.plant.mechanism.element_error import ElementError
from frictool.reduce.chain import ReductionChain, chain
from frictool.reduce.final_step import final
from frictool.reduce.interval_propagation import propagated
from frictool.reduce.model_document import model_of
from frictool.reduce.simulation_check import SimulationCheck, check_reduction


@dataclass(frozen=True)
class Reduction:
    """What the command writes and tells."""

    chain: ReductionChain
    model: Model
    checked: SimulationCheck


TOLERANCE = 0.05  # of the way


def reduce(
    mechanism: Mechanism,
    *,
    bandwidth: float | None = None,
    tolerance: float = TOLERANCE,
    bench: Bench | None = None,
    provenance: Provenance | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Reduction:
    """What `frictool reduce` does: the one-inertia model of a mechanism, with what each step
    neglects.

    bandwidth [rad/s]: resonances below it are kept, needed where a link yields. bench: in place of
    the mechanism's own source and sensor. Raises DocumentError where the mechanism is none,
    NoSolutionError where a step cannot be made or its error is beyond `tolerance`.
    """
    origin = provenance or provenance_of_call("frictool.reduce.reduce", mechanism=mechanism)
    try:
        found = reduction(mechanism, bandwidth, tolerance, bench, origin, progress)
    except ElementError as wrong:
        raise document_error("mechanism", wrong.key, str(wrong)) from None
    if found.checked.refused is not None:
        raise NoSolutionError(f"{found.chain.whole.name}: not reduced: {found.checked.refused}")
    return found


def reduction(
    whole: Mechanism,
    bandwidth: float | None,
    tolerance: float,
    bench: Bench | None,
    provenance: Provenance,
    progress: Callable[[str], None],
) -> Reduction:
    """Reduces, propagates the intervals, plays every step. Raises WrongElement and NoSolutionError
    as `chain` and `checked` do."""
    steps = chain(whole, bandwidth, progress)

    def numbers(mechanism: Mechanism) -> dict[str, float]:
        return chain(mechanism, bandwidth, number=steps.one.beside.number).one.scalars()

    model = model_of(steps, propagated(whole, numbers, progress), provenance, bench)
    return Reduction(
        steps, model, check_reduction(steps, model, final(steps, model.axis), tolerance, progress)
    )

"""Reduction of a mechanism in one call: chain of steps, intervals, model and check."""

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
from frictool.reduce.final_step import final
from frictool.reduce.interval_propagation import propagated
from frictool.reduce.model_document import model_of
from frictool.reduce.partial_travel import restrict_travel
from frictool.reduce.reduction_chain import ReductionChain, chain
from frictool.reduce.simulation_check import TOLERANCE, SimulationCheck, check_reduction
from frictool.runtime.object_view import ResultView


@dataclass(frozen=True)
class ReductionRequest:
    """Request for a reduction.

    Attributes
    ----------
    bandwidth : float or None
        Resonances below this frequency [rad/s] are kept, resonances above it are removed; required
        if a link is compliant.
    travel : tuple of float or None
        Part (low, high) of the travel for which the model is made, in the coordinate of the sensor
        [rad | m]; None for the whole travel.
    tolerance : float
        Largest allowed error of a step: position error divided by the distance travelled.
    bench : Bench or None
        Bench document of the model; None to derive it from the mechanism's source and sensor.
    """

    bandwidth: float | None = None
    travel: tuple[float, float] | None = None
    tolerance: float = TOLERANCE
    bench: Bench | None = None

    def part_of(self, whole: Mechanism) -> Mechanism:
        """Return the mechanism with the requested travel.

        Raises OutsideTravelError if this travel is not within the mechanism's travel.
        """
        return whole if self.travel is None else restrict_travel(whole, self.travel)


USUAL = ReductionRequest()


@dataclass(frozen=True, eq=False, repr=False)
class Reduction(ResultView):
    """Result of a reduction: its steps, the model and the check by simulation."""

    chain: ReductionChain
    model: Model
    checked: SimulationCheck


def reduce(
    mechanism: Mechanism,
    request: ReductionRequest = USUAL,
    *,
    provenance: Provenance | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Reduction:
    """Reduce a mechanism to its one-inertia model, with the error of each step.

    Parameters
    ----------
    mechanism : Mechanism
        Document of the mechanism.
    request : ReductionRequest, optional
        Bandwidth, travel, tolerance and bench document of the reduction.
    provenance : Provenance, optional
        Provenance to be written into the model; None: the provenance of this call.
    progress : Callable, optional
        Callback that receives the name of each stage when the stage begins.

    Returns
    -------
    Reduction
        Steps, model, and check by simulation.

    Raises
    ------
    DocumentError
        If the mechanism is invalid.
    OutsideTravelError
        If the requested travel is not within the travel of the mechanism.
    NoSolutionError
        If a step is impossible, or its error exceeds the tolerance.
    """
    origin = provenance or provenance_of_call("frictool.reduce.reduce", mechanism=mechanism)
    try:
        result = reduction(mechanism, request, origin, progress)
    except ElementError as wrong:
        raise document_error("mechanism", wrong.key, str(wrong)) from None
    if result.checked.refused is not None:
        raise NoSolutionError(f"{result.chain.whole.name}: not reduced: {result.checked.refused}")
    return result


def reduction(
    mechanism: Mechanism,
    request: ReductionRequest,
    provenance: Provenance,
    progress: Callable[[str], None],
) -> Reduction:
    """Reduce the mechanism, propagate the intervals, and check every step by simulation.

    Raises OutsideTravelError for an impossible travel, and NoSolutionError if a step is impossible
    or has an error that is too large.
    """
    whole = request.part_of(mechanism)
    steps = chain(whole, request.bandwidth, progress)

    def numbers(one: Mechanism) -> dict[str, float]:
        return chain(one, request.bandwidth, number=steps.one.residual.number).one.scalars()

    model = model_of(steps, propagated(whole, numbers, progress), provenance, request.bench)
    checked = check_reduction(steps, model, final(steps, model.axis), request.tolerance, progress)
    return Reduction(steps, model, checked)

"""A mechanism reduced: the chain of steps, intervals, model and check, in one call."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from frictool.documents.bench import Bench
from frictool.documents.lines import complaint
from frictool.documents.mechanism import Mechanism
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance, called
from frictool.errors import NoSolutionError
from frictool.plant.mechanism.wrong import WrongElement
from frictool.reduce.chain import Chain, chain
from frictool.reduce.checked import Checked, checked
from frictool.reduce.final import final
from frictool.reduce.intervals import propagated
from frictool.reduce.model import model_of


@dataclass(frozen=True)
class Reduction:
    """What the command writes and tells."""

    chain: Chain
    model: Model
    checked: Checked


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
    """What `frictool reduce` does: the one-inertia model of a mechanism, with what each step neglects.

    bandwidth [rad/s]: resonances below it are kept, needed where a link yields. bench: in place of the mechanism's own source and sensor.
    Raises DocumentError where the mechanism is none, NoSolutionError where a step cannot be made or its error is beyond `tolerance`.
    """
    origin = provenance or called("frictool.reduce.reduce", mechanism=mechanism)
    try:
        found = reduction(mechanism, bandwidth, tolerance, bench, origin, progress)
    except WrongElement as wrong:
        raise complaint("mechanism", wrong.key, str(wrong)) from None
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
    """Reduces, propagates the intervals, plays every step. Raises WrongElement and NoSolutionError as `chain` and `checked` do."""
    steps = chain(whole, bandwidth, progress)

    def numbers(mechanism: Mechanism) -> dict[str, float]:
        return chain(mechanism, bandwidth, number=steps.one.beside.number).one.scalars()

    model = model_of(steps, propagated(whole, numbers, progress), provenance, bench)
    return Reduction(steps, model, checked(steps, model, final(steps, model.axis), tolerance, progress))

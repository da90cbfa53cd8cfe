"""A mechanism reduced: the chain of steps, intervals, model and check, in one call."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from frictool.documents.bench import Bench
from frictool.documents.mechanism import Mechanism
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
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

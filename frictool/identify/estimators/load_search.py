"""Search for load terms that the bench does not declare, by the prediction of unseen strokes.

Terms are added one at a time. A term is kept if the squares of the strokes decrease beyond chance
and the held-out error falls by a fifth. The candidates are a spring and, on a rotary axis, gravity.
Viscous friction that differs by direction is left to the simulation (`structure_selection`). Ripple
needs a declared number of cycles.
"""

from __future__ import annotations

import msgspec
import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.load_terms import LoadTerms, Term
from frictool.identify.fit_result import SLIDING, UnusableLogs
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.regression.term_selection import (
    by_stroke,
    clearly_better,
    halved,
    held_out_squares,
)
from frictool.identify.regression.tsqr import Tensor
from frictool.identify.rows.load_columns import indistinct_terms
from frictool.identify.rows.load_terms import TERMS
from frictool.identify.rows.regression_samples import parameters_of, reduced
from frictool.identify.rows.slip_fit import SMALLEST_SHARE, slipping
from frictool.typing import IntVector, Vector


def with_supported_loads(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> Bench:
    """Return the bench with the load terms that the logs support.

    The bench is unchanged if it declares its loads, if no term is supported, or if nothing slips.
    """
    if bench.load is not None or any(record.velocity is not None for record in records):
        return bench
    possible: tuple[Term, ...] = ("spring", "gravity") if bench.axis == "rotary" else ("spring",)
    try:
        samples, used = slipping(
            records, with_load(bench, possible), SMALLEST_SHARE, settings.window
        )
        names, refused = parameters_of(samples)
    except UnusableLogs:
        return bench
    if names != SLIDING or refused:
        return bench
    plain, _, _, stroke = reduced(samples, np.ones(samples.velocity.size), len(names), used)
    terms = supported_terms(
        plain,
        stroke,
        (*names, *samples.loads),
        possible,
        samples.velocity.size,
        settings.confidence,
    )
    return with_load(bench, terms) if terms else bench


def supported_terms(
    plain: Tensor,
    stroke: IntVector,
    names: tuple[str, ...],
    possible: tuple[Term, ...],
    rows: int,
    confidence: float,
) -> tuple[Term, ...]:
    """Return the supported terms of `possible`, the best first.

    `plain` (g, q, q) are the triangles and `stroke` (g,) the strokes of g runs of rows; `rows` is
    the number of rows in all runs.
    """
    columns = list(range(len(SLIDING)))
    selected = list[Term]()
    half = halved(stroke)
    best = held_out_squares(plain, plain, half, columns)
    while best is not None:
        tried: list[tuple[float, Term, list[int], Vector]] = []
        for term in set(possible) - set(selected):
            seen = [*columns, *(k for k, name in enumerate(names) if name in TERMS[term])]
            squares = held_out_squares(plain, plain, half, seen)
            if squares is not None and not indistinct_terms(
                plain[:, :, [*seen, -1]], [names[k] for k in seen], rows
            ):
                tried.append((float(np.sum(squares)), term, seen, squares))
        if not tried:
            break
        _, term, seen, squares = min(tried, key=lambda one: one[:2])
        if not clearly_better(by_stroke(squares, stroke), by_stroke(best, stroke), confidence):
            break
        columns, best = seen, squares
        selected.append(term)
    return tuple(selected)


def with_load(bench: Bench, terms: tuple[Term, ...]) -> Bench:
    """Return the bench with an offset and these load terms declared."""
    return msgspec.structs.replace(bench, load=LoadTerms(("offset", *terms)))

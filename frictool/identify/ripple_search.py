"""Ripples over the position that a log of sliding shows and the model lacks.

`explanation_search` looks for ripples with smoothing windows that suit the acceleration. A window
as long as the time in which the axis moves by one period of a ripple hides this ripple. In this
module, the windows are halved until they are the shortest possible.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import msgspec

from frictool.documents.bench import Bench
from frictool.identify.estimators.explanation_search import FALSE_ALARM
from frictool.identify.estimators.load_hypotheses import harmonic
from frictool.identify.estimators.searched_records import SearchedRecords
from frictool.identify.fit_result import SlidingFit, UnusableLogs
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.load_terms import RIPPLES, bench_with_terms, terms_of
from frictool.identify.rows.smoothing import SHORTEST


class MissingRipple(NamedTuple):
    """Ripple that the model lacks: wave number `number`, 1/rad | 1/m; `amplitude`, N m | N."""

    number: float
    amplitude: float


def missing_ripples(
    fit: SlidingFit, records: Sequence[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> tuple[MissingRipple, ...]:
    """Return the significant ripples in the residual of a fit, at most one per window length."""
    if fit.load is None:
        explained = bench_with_terms(bench, terms_of(fit.laws))
    else:
        explained = msgspec.structs.replace(bench, load=fit.load)
    try:
        searched = SearchedRecords.of(records, explained, settings)
    except UnusableLogs:
        return ()
    halvings = math.ceil(math.log2(max(searched.windows) / SHORTEST))
    level = FALSE_ALARM / (halvings + 1)
    found: list[MissingRipple] = []
    for k in range(halvings + 1):
        numbers = [ripple.number for ripple in found]
        one = _missing_ripple(searched.smoother(0.5**k), numbers, level)
        found += () if one is None else (one,)
    return tuple(found)


def _missing_ripple(
    searched: SearchedRecords, found: Sequence[float], level: float
) -> MissingRipple | None:
    """Return the ripple at the highest peak of the spectrum if it is significant, else None.

    Peaks at the wave numbers `found` are ignored. `level` is the permitted probability that noise
    looks like a ripple.
    """
    waves = (*searched.declared_waves, *found)
    used = [harmonic(term) for term in RIPPLES[len(searched.declared_waves) : len(waves)]]
    try:
        ripple = searched.ripple(searched.rows(waves), waves, used)
        if ripple is None:
            return None
        hypothesis, peak = ripple
        rows = searched.rows((*waves, peak.number))
    except UnusableLogs:
        return None
    chance = rows.probability(hypothesis, used)
    if not rows.visible(hypothesis, used) or chance >= level / peak.tried:
        return None
    return MissingRipple(peak.number, rows.amplitude(hypothesis, used))

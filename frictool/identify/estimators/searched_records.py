"""Records of one axis, with regression rows, for the search for explanations of the effort.

A hypothesis is a load or an effect that may act, such as a spring. The rows have the columns of all
hypotheses that the records can test, and of ripples whose wave numbers follow from the residual
over the position.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import msgspec
import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.load_terms import MOST_HARMONICS, LoadTerms
from frictool.identify.estimators.hypothesis_rows import ReducedRows
from frictool.identify.estimators.load_hypotheses import (
    LOADS,
    Structure,
    declared_term,
    harmonic,
    wave_numbers,
)
from frictool.identify.estimators.position_spectrum import (
    SpectrumPeak,
    best_whole_number,
    highest_peak,
    rounded_wave_number,
)
from frictool.identify.fit_result import SLIDING, UnusableLogs
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.regression.term_selection import halved
from frictool.identify.rows.effects import EFFECTS, Hypothesis
from frictool.identify.rows.load_terms import GRAVITY, RIPPLES, SPRING, TERMS
from frictool.identify.rows.regression_samples import (
    RegressionSamples,
    joined,
    parameters_of,
    reduced,
)
from frictool.identify.rows.slip_fit import SMALLEST_SHARE, slipping_rows, stroke_samples
from frictool.identify.rows.smoothing import (
    SHORTEST,
    acceleration_response,
    choose_window,
    measurement_noise,
    smoothed,
)
from frictool.identify.rows.temperature_law import temperatures, varies

LONGEST_SHARE = 0.25  # longest window of `smoother`, relative to a stroke
# number of regression rows per smoothing window; the windows of successive rows overlap
ROWS_PER_WINDOW = 8
MOST_ROWS = 8_000  # approximate largest number of rows of all records
# largest number of samples that are searched; in longer logs, PARTS evenly spaced parts are
# searched
MOST_SAMPLES, PARTS = 300_000, 20
ECCENTRICITY = "eccentricity"
NOISY = 2.0 * SMALLEST_SHARE  # share of noise above which the acceleration counts as noisy


@dataclass(frozen=True)
class SearchedRecords:
    """Records of one axis in which explanations of the effort are searched.

    - windows: length of the smoothing window of each record, samples
    - widens: True if `hypotheses` also contains effects that only widen the intervals of the
      parameters
    """

    records: Sequence[MotionRecord]
    bench: Bench
    settings: IdentificationSettings
    windows: tuple[int, ...]
    widens: bool = False

    @classmethod
    def of(
        cls, records: Sequence[MotionRecord], bench: Bench, settings: IdentificationSettings
    ) -> SearchedRecords:
        """Return `records` for the search; long records are reduced to evenly spaced parts.

        Raises UnusableLogs if the axis never moves by more than one encoder count.
        """
        share = MOST_SAMPLES / sum(record.position.size for record in records)
        parts = [_thinned(record, share) for record in records]
        lengths = [stroke_samples(record) for record in parts]
        moving = [
            (part, settings.window or choose_window(part, length, SMALLEST_SHARE))
            for part, length in zip(parts, lengths, strict=True)
            if length > 0.0
        ]
        if not moving:
            raise UnusableLogs(
                "the axis never moves by more than one encoder count; record longer strokes"
            )
        used, windows = zip(*moving, strict=True)
        return cls(used, bench, settings, windows)

    def smoother(self, factor: float) -> SearchedRecords:
        """Return the records with smoothing windows that are `factor` times as long.

        Windows that become longer are limited to a quarter of the record's median stroke. Windows
        that become shorter keep at least SHORTEST samples.
        """
        longest = (LONGEST_SHARE * stroke_samples(record) for record in self.records)
        windows = tuple(
            max(
                window if factor >= 1.0 else SHORTEST,
                2 * int(0.5 * min(factor * window, most)) + 1,
            )
            for window, most in zip(self.windows, longest, strict=True)
        )
        return replace(self, windows=windows)

    @property
    def rotary(self) -> bool:
        """Return whether the axis is rotary."""
        return self.bench.axis == "rotary"

    @property
    def declared_waves(self) -> tuple[float, ...]:
        """Return the wave numbers of the ripple that the bench declares, 1/rad | 1/m."""
        return wave_numbers(self.bench.load)

    @property
    def hypotheses(self) -> tuple[Hypothesis, ...]:
        """Return the hypotheses that the records can test, in the order of `LOADS` and `EFFECTS`.

        Ripples and the load terms that the bench declares are not included.
        """
        named = () if self.bench.load is None else self.bench.load.terms
        measured = any(record.velocity is not None for record in self.records)
        return tuple(
            one
            for one in (*LOADS, *EFFECTS)
            if declared_term(one) not in named
            and (self.widens or not one.only_widens)
            and not (one.term == GRAVITY and not self.rotary)
            and not (one.term == ECCENTRICITY and not self.rotary)
            and not (measured and one.needs_position)
            and (not one.needs_temperature or self.warmed)
        )

    @cached_property
    def warmed(self) -> bool:
        """Return whether the temperature was logged in all records, and varies enough for a fit."""
        return varies(temperatures(self.records))

    def samples(self, waves: tuple[float, ...]) -> RegressionSamples:
        """Return the regression rows with the columns of all hypotheses.

        Ripples with the wave numbers `waves` [1/rad | 1/m] have columns, too. Raises UnusableLogs
        if no slip is as long as a smoothing window.
        """
        return joined(self.samples_of_records(waves))

    def samples_of_records(self, waves: tuple[float, ...]) -> list[RegressionSamples]:
        """Return the regression rows of `samples` separately for each record.

        Raises UnusableLogs if no slip is as long as a smoothing window.
        """
        declared = self.bench.load or LoadTerms(("offset",))
        terms = (*(one.term for one in self.hypotheses), *RIPPLES[: len(waves)])
        load = Structure(terms, waves).load(self.rotary)
        named = dict.fromkeys((*declared.terms, *load.terms[1:]))
        load = msgspec.structs.replace(declared, terms=tuple(named), ripple=load.ripple)
        bench = msgspec.structs.replace(self.bench, load=load)
        size = sum(record.position.size for record in self.records)
        least_step = max(1, size // MOST_ROWS)
        parts = []
        for record, window in zip(self.records, self.windows, strict=True):
            every = max(least_step, window // ROWS_PER_WINDOW)
            parts.append(slipping_rows(record, bench, window, smoothed(record, window), every))
        if all(part.velocity.size == 0 for part in parts):
            raise UnusableLogs(
                "the axis never slips throughout a smoothing window; record longer strokes"
            )
        return parts

    def rows(self, waves: tuple[float, ...]) -> ReducedRows:
        """Return the regression rows with the columns of all hypotheses, as triangular matrices.

        Ripples with the wave numbers `waves` [1/rad | 1/m] have columns, too. Raises UnusableLogs
        if no slip is as long as a smoothing window, or if the motion does not determine Coulomb
        friction and offset.
        """
        samples = self.samples(waves)
        names, refused = parameters_of(samples)
        if names[:3] != SLIDING[:3] or "coulomb" in refused:
            raise UnusableLogs(
                "the motion does not determine Coulomb friction and offset; record both directions"
            )
        return self.reduced_rows(samples, waves)

    def reduced_rows(self, samples: RegressionSamples, waves: tuple[float, ...]) -> ReducedRows:
        """Return the regression rows `samples`, reduced to triangular matrices by QR.

        `waves` are the wave numbers [1/rad | 1/m] of the ripples with columns in `samples`. The
        base columns, which every fit includes, are the columns of the sliding parameters without a
        fixed value, and of the loads that the bench declares.
        """
        names = parameters_of(samples)[0]
        plain, _, cluster, stroke = reduced(
            samples, np.ones(samples.velocity.size), len(names), ROWS_PER_WINDOW
        )
        tried = {name for one in self.hypotheses for name in one.names}
        fixed = len(self.declared_waves)
        tried |= {name for term in RIPPLES[fixed : len(waves)] for name in TERMS[term]}
        every_name = (*names, *samples.loads)
        base = tuple(name for name in every_name if name not in tried and name not in samples.fixed)
        return ReducedRows(samples, plain, cluster, stroke, every_name, base, self.noise)

    @property
    def noise(self) -> float:
        """Return the rms noise of the first record's acceleration, rad/s^2 | m/s^2."""
        record = self.records[0]
        response = acceleration_response(record, self.windows[0])
        return measurement_noise(record) * float(np.linalg.norm(response))

    def noisy(self, samples: RegressionSamples) -> bool:
        """Return whether the acceleration in `samples` is too noisy to test some effects.

        The noise makes the fitted inertia too small, so that a part of the inertial effort is left
        over. The effects `delay` and `resonance` would be fitted to this part.
        """
        return self.noise > NOISY * float(np.sqrt(np.mean(samples.acceleration**2)))

    def shortest_period(self, rows: ReducedRows) -> float:
        """Return the shortest period of a ripple that smoothing does not remove, rad | m."""
        speed = float(np.quantile(np.abs(rows.samples.velocity), 0.25))
        return max(
            max(speed * window * record.period, 4.0 * record.resolution)
            for window, record in zip(self.windows, self.records, strict=True)
        )

    def ripple(
        self, rows: ReducedRows, waves: tuple[float, ...], used: Sequence[Hypothesis]
    ) -> tuple[Hypothesis, SpectrumPeak] | None:
        """Return the ripple at the highest peak in the spectrum of the residual, and this peak.

        - waves: wave numbers of the ripples that the fit includes already, 1/rad | 1/m
        - used: hypotheses in the fit whose residual is examined

        Return None if the rows have no column of the position, if the fit has MOST_HARMONICS
        ripples, or if the spectrum has no peak.
        """
        position = rows.samples.loads.get(TERMS[SPRING][0])
        if position is None or len(waves) == MOST_HARMONICS:
            return None
        half = halved(np.unique(rows.samples.stroke, return_inverse=True)[1])
        excluded = (*waves, *((1.0,) if self.rotary else ()))
        peak = highest_peak(
            position, rows.residual(used), half, self.shortest_period(rows), excluded
        )
        if peak is None:
            return None
        if self.rotary:
            peak = replace(peak, number=rounded_wave_number(peak))
        return self._harmonic(waves, peak.number), peak

    def long_ripple(
        self, rows: ReducedRows, waves: tuple[float, ...], used: Sequence[Hypothesis]
    ) -> tuple[Hypothesis, SpectrumPeak] | None:
        """Return the ripple of few periods that reduces the residual most, and its spectral peak.

        On a rotary axis, a ripple has a whole number of cycles per turn. With few periods within
        the travel, the other loads resemble the ripple. The spectrum of the residual then does not
        show the number of cycles; each whole number is tried instead. Parameters are those of
        `ripple`.
        """
        position = rows.samples.loads.get(TERMS[SPRING][0])
        if not self.rotary or position is None or len(waves) == MOST_HARMONICS:
            return None
        peak = best_whole_number(position, rows.table(used), rows.residual(used), waves)
        return None if peak is None else (self._harmonic(waves, peak.number), peak)

    def _harmonic(self, waves: tuple[float, ...], number: float) -> Hypothesis:
        """Return the hypothesis of a further ripple; `number` is its wave number, 1/rad | 1/m."""
        if self.rotary:
            shown = f"{number:.4g} cycles a turn"
            key = f"{{cycles: {number:.4g}, per: {{value: 1, unit: turn}}}}"
        else:
            length = 2e3 * np.pi / number
            shown = f"a period of {length:.4g} mm"
            key = f"{{cycles: 1, per: {{value: {length:.4g}, unit: mm}}}}"
        what = f"a ripple over the position with {shown}"
        settle = f"declare load: {{terms: [offset, ripple], ripple: {key}}}"
        return harmonic(RIPPLES[len(waves)], what, settle)


def _thinned(record: MotionRecord, share: float) -> MotionRecord:
    if share >= 1.0:
        return record
    size = record.position.size
    length = int(share * size / PARTS)
    starts = np.linspace(0, size - length, PARTS).astype(np.int64)
    index = (starts[:, None] + np.arange(length)).ravel()
    kept = record.part(index)
    breaks = np.diff(kept.piece, prepend=0) != 0
    breaks[length::length] = True
    return replace(kept, piece=np.cumsum(breaks))

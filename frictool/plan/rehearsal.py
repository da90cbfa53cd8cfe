"""Rehearsals of a test: simulations of the test, with identification from the simulated log.

The half width that `identify` reports depends on the encoder, on the speed and on the method of
identification. Each rehearsal draws the parameters of an axis from the a-priori intervals,
simulates the test with encoder counts, delay and noise, and records the half widths. The half width
that `excite` states for a parameter is an upper bound from a lognormal distribution that is fitted
to the half widths of the rehearsals. The rehearsals of a test end as soon as no result of the
remaining ones can bring this bound below the requested half width.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from types import MappingProxyType

import numpy as np

from frictool.documents.bench import DRIVE_NOISE_SHARE, Bench
from frictool.documents.laws import Laws
from frictool.documents.model import Model
from frictool.identify.excite.excitation_sequence import ExcitationSequence
from frictool.identify.fit_result import PARAMETERS
from frictool.identify.from_logs import identify
from frictool.identify.identification import NothingIdentified
from frictool.identify.model_document import LARGEST_BREAKAWAY_RATIO
from frictool.plan.assumed_axis import assumed_axis
from frictool.simulate import play
from frictool.simulate.default_servo import default_servo, feedforward

REHEARSALS = 8
# distance of the upper bound from the mean, in standard deviations of REHEARSALS draws: with a
# confidence of 90 %, at least 97 % of the normal distribution lies below the bound (noncentral t
# distribution)
SPREAD = 3.1
CONFIRMED_SPREAD = 2.6  # value of SPREAD if there are at least twice REHEARSALS draws
STREAM = 43  # index of the stream of random numbers
NONE_BEFORE: Mapping[str, HalfWidthSample] = MappingProxyType({})


@dataclass(frozen=True)
class HalfWidthSample:
    """Half widths of one parameter's interval in all rehearsals, in SI units.

    - widths: half widths from the rehearsals that identified the parameter
    - refusals: reasons why the other rehearsals did not identify the parameter
    - exceeded: True if the rehearsals ended because the bound exceeds the limit
    """

    widths: tuple[float, ...]
    refusals: tuple[str, ...]
    exceeded: bool = False

    @property
    def upper(self) -> float:
        """Return the upper bound of the half width that `identify` is expected to report.

        The bound is infinite if a rehearsal did not identify the parameter. If the rehearsals ended
        early because of a single half width, the largest half width is returned in place of a
        bound. If they ended early because of the bound, the bound of fewer half widths is returned,
        which is also above the limit.
        """
        return self._bound(CONFIRMED_SPREAD if len(self.widths) >= 2 * REHEARSALS else SPREAD)

    @property
    def likely(self) -> float:
        """Return the bound that `upper` would give after more rehearsals with similar results."""
        return self._bound(CONFIRMED_SPREAD)

    def _bound(self, spread: float) -> float:
        if self.refusals or not self.widths:
            return math.inf
        if len(self.widths) < REHEARSALS and not self.exceeded:
            return max(self.widths)
        logarithms = np.log(self.widths)
        bound = float(np.exp(logarithms.mean() + spread * logarithms.std(ddof=1)))
        return max(bound, *self.widths)

    def joined(self, other: HalfWidthSample) -> HalfWidthSample:
        """Return one sample with the half widths of both samples."""
        return HalfWidthSample(
            self.widths + other.widths,
            self.refusals + other.refusals,
            self.exceeded or other.exceeded,
        )


def least_bound(widths: Sequence[float], total: int) -> float:
    """Return the least value of `likely` that further rehearsals can lead to.

    `total` is the number of rehearsals in the end. The k known logarithms have the mean m and the
    sum of squared deviations S; the r others are free. m + CONFIRMED_SPREAD s is least if these r
    logarithms are equal, because for a given mean this makes s least. The least value is then

        m + sqrt(S (CONFIRMED_SPREAD^2/(total - 1) - r/(k total)))

    and there is no least value if the difference under the root is negative.
    """
    known = len(widths)
    left = CONFIRMED_SPREAD**2 / (total - 1) - (total - known) / (known * total)
    if left < 0.0:
        return 0.0
    logarithms = np.log(widths)
    squares = float(np.sum((logarithms - logarithms.mean()) ** 2))
    return math.exp(float(logarithms.mean()) + math.sqrt(squares * left))


def rehearse(
    sequence: ExcitationSequence,
    bench: Bench,
    limits: Mapping[str, float],
    noise: float | None = None,
    seeds: Sequence[int] = (0,),
    laws: Laws | None = None,
    before: Mapping[str, HalfWidthSample] = NONE_BEFORE,
) -> dict[str, HalfWidthSample]:
    """Simulate a test REHEARSALS times per seed; return the half widths that `identify` reports.

    The rehearsals end early as soon as the half width of a parameter exceeds its limit, a parameter
    with a finite limit is not identified, or no result of the remaining rehearsals can bring the
    bound `likely` of a parameter below its limit.

    Parameters
    ----------
    sequence
        Test as a reference of the position loop or as a command of the drive.
    bench
        Bench with the a-priori intervals from which the parameters of the axes are drawn.
    limits
        Largest permitted half width of each parameter in SI units; inf for no limit.
    noise
        Standard deviation of the noise of the measured current or voltage, A | V; None for 0.2 % of
        the drive's limit.
    seeds
        Seeds of the random axes and of the noise.
    laws
        Friction laws of the axes in addition to their parameters, such as friction over position.
    before
        Half widths of earlier rehearsals of the same test with other axes. They are part of the
        result.

    Returns
    -------
    dict
        Half widths of each parameter over the rehearsals, by the parameter's name.
    """
    samples = {name: before.get(name, HalfWidthSample((), ())) for name in limits}
    total = REHEARSALS * len(seeds) + max(len(one.widths) for one in samples.values())
    for model, number in chain.from_iterable(_drawn_axes(bench, seed, laws) for seed in seeds):
        widths, refused = _rehearsed(sequence, bench, model, noise, number)
        for name, limit in limits.items():
            sample = (
                HalfWidthSample((widths[name],), ())
                if name in widths
                else HalfWidthSample((), (refused.get(name, "not identified"),))
            )
            joined = samples[name].joined(sample)
            within = max(joined.widths, default=math.inf) <= limit
            exceeded = within and least_bound(joined.widths, total) > limit
            samples[name] = replace(joined, exceeded=exceeded)
        if any(
            widths.get(name, math.inf) > limit or samples[name].exceeded
            for name, limit in limits.items()
        ):
            break
    return samples


def _rehearsed(
    sequence: ExcitationSequence, bench: Bench, model: Model, noise: float | None, seed: int
) -> tuple[dict[str, float], dict[str, str]]:
    test = sequence.as_log("rehearsal")
    log = play(
        model,
        test,
        servo=default_servo(bench),
        drive_noise=DRIVE_NOISE_SHARE * bench.actuator.limit.value if noise is None else noise,
        seed=seed,
        forward=feedforward(bench, test),
    )
    try:
        result = identify([log], bench).result
    except NothingIdentified as error:
        result = error.result
    widths = {name: one.half_width for name, one in result.identified.items()}
    return widths, dict(result.refused)


def _drawn_axes(bench: Bench, seed: int, laws: Laws | None) -> Iterator[tuple[Model, int]]:
    draw = np.random.default_rng([seed, STREAM])
    for _ in range(REHEARSALS):
        values = {
            name: float(draw.uniform(*known.interval))
            for name in PARAMETERS
            if (known := getattr(bench.mechanics, name)) is not None
        }
        values.setdefault("offset", 0.0)
        # without a breakaway in the bench, a ratio to the Coulomb friction is drawn
        ratio = draw.uniform(1.0, LARGEST_BREAKAWAY_RATIO)
        breakaway = values.get("breakaway", ratio * values["coulomb"])
        values["breakaway"] = max(breakaway, values["coulomb"])
        yield assumed_axis(bench, values, laws), int(draw.integers(2**31))

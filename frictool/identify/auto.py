"""Which method, and why: the decision scheme of figure 4.4 on what the record shows.

    1  the encoder's noise on the smoothed velocity attenuates viscous friction by more than the share allowed    sines
    2  the efficient estimate (`least_squares`) and the robust one (`power_balance`) disagree by more than their
       intervals: friction is not viscous + Coulomb over all speeds, and the slow samples tell something else     power-balance
    3  else                                                                                                       least-squares
    4  simulated on strokes that were not seen, output error is off by a tenth less than what 2 or 3 gives        output-error

Whether the inertia can be had is a question of its own that each method answers. Step 2 is Hausman's test, read off intervals. Offset
and viscous friction are dropped where strokes that the fit has not seen are predicted no worse without them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.methods import Settings, run
from frictool.identify.outcome import Fit
from frictool.identify.power_balance import by_speed
from frictool.identify.record import Record
from frictool.identify.refusals import refuse_self_explained
from frictool.identify.samples import Samples
from frictool.identify.slipping import SMALLEST_SHARE, slipping, weighted_fit
from frictool.identify.smoothing import bump, position_noise

LARGEST_ATTENUATION = 1e-3  # of viscous friction: noise of the velocity over the velocity, squared
DROPPABLE = ("viscous", "offset")


def auto(records: list[Record], bench: Bench, settings: Settings) -> Fit:
    """Inertia, viscous, Coulomb and offset by the method that suits the records. Raises NothingUsable where nothing moves enough."""
    samples, used = slipping(records, bench, SMALLEST_SHARE, settings.window)
    attenuation = velocity_noise(samples, used, records[0]) ** 2
    if attenuation > LARGEST_ATTENUATION:
        why = f"the encoder's noise on the velocity would attenuate viscous friction by {100 * attenuation:.2g} %"
        return replace(run("sines", records, bench, settings), method="sines", why=why)
    efficient = weighted_fit(records, bench, settings, lambda rows: np.ones(rows.velocity.size), DROPPABLE)
    robust = weighted_fit(records, bench, settings, by_speed)
    apart = disagreement(efficient, robust)
    if apart is None:
        why = "equal weights and weights by speed agree within their intervals: friction is viscous and Coulomb at all speeds used"
        return _refined(records, bench, settings, replace(efficient, method="least-squares", why=why))
    why = f"{apart} with equal weights is outside what weights by speed give: the slow samples tell another friction, and count less"
    return _refined(records, bench, settings, replace(robust, method="power-balance", why=why))


def _refined(records: list[Record], bench: Bench, settings: Settings, fit: Fit) -> Fit:
    """Step 4, imported when it is used. A computed effort is refused before: simulated, it would no longer explain itself."""
    from frictool.identify.output_error import refined

    refuse_self_explained(fit, records)
    return refined(records, bench, settings, fit)


def velocity_noise(samples: Samples, window: int, record: Record) -> float:
    """rms of the noise that the position leaves on the smoothed velocity, over the rms of the velocity."""
    response = np.convolve(bump(window, record.period), [1.0, 0.0, -1.0]) / (2.0 * record.period)
    return position_noise(record) * float(np.linalg.norm(response)) / float(np.sqrt(np.mean(samples.velocity**2)))


def disagreement(one: Fit, other: Fit) -> str | None:
    """The first parameter of friction whose intervals have nothing in common, for people; None where all agree."""
    for name in ("viscous", "coulomb"):
        a, b = one.parameters.get(name), other.parameters.get(name)
        if a is not None and b is not None and (a.low > b.high or b.low > a.high):
            return f"{name} {a.value:.4g}"
    return None

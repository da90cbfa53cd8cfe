"""Warning of a lag of the position sensor that the logs can neither show nor exclude.

A lag tau of the reported position increases the fitted inertia by about tau times the viscous
friction. Motions that are slow compared with the time constant inertia/viscous do not distinguish
the lag from a larger inertia.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from frictool.documents.bench import Bench
from frictool.documents.quantity import si_unit
from frictool.identify.effect_regression import EffectRegression
from frictool.identify.fit_result import Interval
from frictool.identify.fitted_lag import lag_is_known, may_be_read_apart
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.effects import DELAY

# shortest and longest usual lag of a 4-20 mA transmitter or of a filtered potentiometer, s
SHORTEST, LONGEST = 0.01, 0.1


def sensor_lag_doubts(
    records: Sequence[MotionRecord],
    bench: Bench,
    regression: EffectRegression,
    wide: Mapping[str, Interval],
) -> list[tuple[str, str]]:
    """Return [("inertia", warning)] if a sensor lag may put the inertia outside its interval.

    Otherwise, the result is []. `wide` contains the interval of the inertia. The warning is for the
    longest lag that is at most LONGEST and within the interval of the delay that the regression
    fits. There is no warning if the bench states the lag, if the model contains a delay, if the log
    excludes lags above SHORTEST, or if the lag is shorter than the time between the readings of
    effort and position in one row of the log.
    """
    late = next((one for one in regression.free if one.term == DELAY), None)
    if late is None or lag_is_known(records, bench):
        return []
    found = regression.intervals([late]).get(DELAY)
    rate = regression.rates(late).get("inertia")
    inertia = wide.get("inertia")
    if found is None or rate is None or inertia is None:
        return []
    lag = min(-found.low, LONGEST)
    if lag <= SHORTEST or may_be_read_apart(lag, records):
        return []
    if inertia.low <= inertia.value - lag * rate <= inertia.high:
        return []
    text = (
        f"a sensor lag raises inertia by the lag times {rate:.3g} "
        f"{si_unit('viscous', bench.axis)}; the log allows a lag of {1e3 * lag:.0f} ms; state "
        "encoder.time_constant_s (0 if none), or record faster reversals"
    )
    return [("inertia", text)]

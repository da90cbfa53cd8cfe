"""The weak (integral) form: the equation of motion times test functions (1 - s^2)^3, integrated over windows.

    inertia int(phi'' x) + viscous int(phi x') + coulomb int(phi sign v) + offset int(phi) = int(phi u)

Nothing is differentiated but the test function, and that by its exact second difference: its analytic second derivative would bias the
inertia by 4-5 %. Windows follow each other at a sixth of their length; closer ones tell nothing more.

The window, and whether the inertia can be had, are those of `assess`: its prediction (assess/weak.py) on the strokes of the records. The
encoder's noise in the regressor of the inertia takes a share off it, which is a range within the interval (`unknowns`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.special import ndtri

from frictool.documents.bench import Bench
from frictool.identify.assess.recorded import recorded_facts
from frictool.identify.assess.verdicts import QUANTILE, percent
from frictool.identify.assess.weak import weak_deviation
from frictool.identify.methods import Settings
from frictool.identify.outcome import Fit, Interval, NothingUsable
from frictool.identify.record import Record
from frictool.identify.regression.unknowns import half_width
from frictool.identify.rows.bell import bell
from frictool.identify.rows.samples import fit, joined
from frictool.identify.rows.slipping import slipping_rows
from frictool.identify.rows.smoothing import smoothed_by

OVERLAP = 6  # windows begin at each sixth of their length


def weak(records: list[Record], bench: Bench, settings: Settings) -> Fit:
    """Inertia, viscous, Coulomb and offset from records of sliding motion. Raises NothingUsable where no window slips throughout."""
    facts = recorded_facts(records, bench)
    deviation, window = weak_deviation(list(facts.strokes), facts.axis, facts.sensing, settings.window)
    every = max(1, window // OVERLAP)
    samples = joined([slipping_rows(one, bench, window, smoothed_by(one, bell(window)), every) for one in records])
    if samples.velocity.size == 0:
        raise NothingUsable("no sample slips for a whole window of the weak form")
    found = fit(samples, np.ones(samples.velocity.size), OVERLAP, settings.confidence, {"window": window})
    precision, known = QUANTILE * float(deviation[0]) / facts.axis.inertia, facts.known.get("inertia", 1.0)
    if precision >= known:
        kept = {name: interval for name, interval in found.parameters.items() if name != "inertia"}
        reason = f"the weak form over {window} samples reaches {percent(precision)}, and the bench knows it to {percent(known)}"
        return replace(found, parameters=kept, refused={**found.refused, "inertia": reason})
    second = np.convolve(bell(window), [1.0, -2.0, 1.0]) / facts.sensing.period**2
    share = facts.sensing.step**2 / 12.0 * float(second @ second) / float(np.mean(samples.acceleration**2))
    inertia = found.parameters["inertia"]
    if not np.isfinite(inertia.half_width):
        return found
    statistical = inertia.half_width / float(ndtri(0.5 + 0.5 * settings.confidence))
    half = half_width(settings.confidence, statistical, [share * abs(inertia.value)])
    return replace(found, parameters={**found.parameters, "inertia": Interval(inertia.value, inertia.value - half, inertia.value + half)})

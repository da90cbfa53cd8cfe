"""Half width that `identify` reports relative to the deviation expected of its estimator.

The expected deviation is that of least squares over windows (assess/weak_form_precision.py), at
least the Cramér-Rao bound. `identify --method auto` estimates its intervals from the residuals.
The factors were measured by `studies/promises`, which plays and identifies optimal tests of ten
benches with drive noise and encoder counts. On an encoder that is too coarse for differences,
`auto` takes friction from the means of strokes, whose intervals are wider.
"""

from __future__ import annotations

from frictool.documents.bench import Bench
from frictool.identify.assess.assessment_inputs import KNOWN_DYNAMICS, time_constants
from frictool.identify.assess.quantisation import viscous_error

METHOD = "auto"
# parameter -> half width over the quantile times the expected deviation
FINE = {"inertia": 1.3, "viscous": 1.3, "coulomb": 1.4, "offset": 1.4}
COARSE = {**FINE, "viscous": 12.0, "coulomb": 12.0}
RAMP_FACTOR = 1.5  # the same factor of the breakaway
COARSE_ERROR = 0.05  # relative error of a speed by one count per sample


def half_width_factor(name: str, bench: Bench, speed: float) -> float:
    """Return the factor of a sliding parameter for strokes with this top speed."""
    fastest, slowest = time_constants(bench)
    unknown = slowest > KNOWN_DYNAMICS * fastest
    error = viscous_error(bench.encoder.resolution, bench.sample_period_s, speed)
    return (COARSE if unknown and error > COARSE_ERROR else FINE)[name]

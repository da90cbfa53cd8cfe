"""The weak (integral) form: the equation of motion times test functions (1 - s^2)^3, integrated over windows.

    inertia int(phi'' x) + viscous int(phi x') + coulomb int(phi sign v) + offset int(phi) = int(phi u)

Nothing is differentiated but the test function, and that by its exact second difference: its analytic second derivative would bias the
inertia by 4-5 %. Windows follow each other at a sixth of their length; closer ones tell nothing more.
"""

from __future__ import annotations

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.methods import Settings
from frictool.identify.outcome import Fit, NothingUsable
from frictool.identify.record import Record, Vector
from frictool.identify.resolution import refuse_hidden_inertia
from frictool.identify.samples import fit, joined
from frictool.identify.slipping import SMALLEST_SHARE, slipping_rows, stroke_samples
from frictool.identify.smoothing import choose_window, smoothed_by

OVERLAP = 6  # windows begin at each sixth of their length


def bell(window: int) -> Vector:
    """phi (window - 2,), sum 1, whose second difference has `window` values."""
    inner = np.linspace(-1.0, 1.0, window)[1:-1]
    phi = (1.0 - inner**2) ** 3
    return np.asarray(phi / phi.sum())


def weak(records: list[Record], bench: Bench, settings: Settings) -> Fit:
    """Inertia, viscous, Coulomb and offset from records of sliding motion. Raises NothingUsable where no window slips throughout."""
    moving = [(record, stroke_samples(record)) for record in records]
    parts, windows = [], [0]
    for record, length in moving:
        if length == 0.0:
            continue
        window = settings.window or choose_window(record, length, SMALLEST_SHARE)
        every = max(1, window // OVERLAP)
        parts.append(slipping_rows(record, bench, window, smoothed_by(record, bell(window)), every))
        windows.append(window)
    if sum(part.velocity.size for part in parts) == 0:
        raise NothingUsable("no sample slips for a whole window of the weak form")
    samples, window = joined(parts), max(windows)
    found = fit(samples, np.ones(samples.velocity.size), OVERLAP, settings.confidence, {"window": window})
    response = np.convolve(bell(window), [1.0, -2.0, 1.0]) / records[0].period ** 2
    return refuse_hidden_inertia(found, records[0], bench, response, samples.acceleration, f"over {window} samples")

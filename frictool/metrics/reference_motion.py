"""Motions of a reference, such as ramps; a change within at most three samples is a step instead.

A *motion* is a maximal sequence of samples in which the reference changes; it may contain pauses of
fewer than 20 samples. A step is not a motion, because no axis can follow it.
"""

from __future__ import annotations

import numpy as np

from frictool.metrics.reference_holds import MIN_SAMPLES, TRANSITION_SAMPLES
from frictool.typing import IntVector, Vector


def changed_samples(reference: Vector) -> IntVector:
    """Return the indices k with |reference[k + 1] - reference[k]| above rounding errors."""
    return np.flatnonzero(np.abs(np.diff(reference)) > 1e-9 * float(np.ptp(reference)))


def find_motions(reference: Vector) -> tuple[tuple[int, int], ...]:
    """Return the motions of `reference` (n,) in order of time.

    Each motion is (start, stop). `start` is the last sample before the motion. `stop` is the first
    sample at which the reference is at rest again; n - 1 if the samples end during the motion.
    """
    changes = changed_samples(reference)
    if not changes.size:
        return ()
    breaks = np.flatnonzero(np.diff(changes) >= MIN_SAMPLES)
    starts = changes[np.concatenate([[0], breaks + 1])]
    stops = changes[np.concatenate([breaks, [changes.size - 1]])] + 1
    long = stops - starts > TRANSITION_SAMPLES + 1
    return tuple(zip(starts[long].tolist(), stops[long].tolist(), strict=True))

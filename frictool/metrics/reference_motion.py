"""Motions of a reference: the parts in which it moves by more than a step.

A *motion* is a maximal run of samples in which the reference changes, with pauses of fewer than 20
samples. A change within at most three samples is a step, not a motion: no axis can follow it.
"""

from __future__ import annotations

import numpy as np

from frictool.metrics.reference_holds import MIN_SAMPLES, TRANSITION_SAMPLES
from frictool.typing import IntVector, Vector


def changed_samples(reference: Vector) -> IntVector:
    """Return the samples of a reference (n,) after which it changes by more than rounding."""
    return np.flatnonzero(np.abs(np.diff(reference)) > 1e-9 * float(np.ptp(reference)))


def find_motions(reference: Vector) -> tuple[tuple[int, int], ...]:
    """Return the motions of `reference` (n,) in order of time.

    Each motion is (start, stop): `start` is the last sample before it, `stop` the first sample at
    which the reference is at rest again, or n - 1 if the record ends in the motion.
    """
    changes = changed_samples(reference)
    if not changes.size:
        return ()
    breaks = np.flatnonzero(np.diff(changes) >= MIN_SAMPLES)
    starts = changes[np.concatenate([[0], breaks + 1])]
    stops = changes[np.concatenate([breaks, [changes.size - 1]])] + 1
    long = stops - starts > TRANSITION_SAMPLES + 1
    return tuple(zip(starts[long].tolist(), stops[long].tolist(), strict=True))

"""Error of a causal velocity estimate along a log, compared with the best low-pass (thesis 5.70).

    position ──central difference, Butterworth forwards and backwards──▶ zero-phase velocity
             ──difference, low-passes of many cut-offs (kernels/low_pass_bank.py)──▶ best low-pass

The zero-phase velocity is the reference from which errors are computed. This reference needs later
samples, and is computed in blocks with margins as long as the filter's memory. The comparison
favours the low-pass: its cut-off is chosen with knowledge of the whole log.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from frictool.control.speed_filter import first_order
from frictool.observe.kernels.low_pass_bank import low_pass_bank
from frictool.typing import Vector

ORDER = 4  # order of the Butterworth filter, which runs forwards and backwards
REMEMBERED = 10.0  # periods of the cut-off frequency after which the response is below 1e-9
BLOCK = 1 << 14  # number of samples that are compared at a time
# lowest cut-off [Hz], and number of low-passes; the highest cut-off equals the cut-off of the mean
# of two differences
SLOWEST_HZ = 1.0
CUTOFFS = 31
LEAST = 12  # smallest number of gap-free samples that are compared


@dataclass
class ErrorSums:
    """Sums of squared velocity errors, and the number of samples.

    - low_passes: sum for each filter of kernels/low_pass_bank.py with m bandwidths, (2 m + 1,)
    - observer: sum for the estimated velocity
    """

    low_passes: Vector
    observer: float = 0.0
    samples: int = 0


@dataclass
class PendingSamples:
    """Last samples (n,) of position, estimated and true velocity, kept for the next block.

    `compared`: number of these samples whose errors have been summed already.
    """

    position: list[Vector] = field(default_factory=list)
    estimate: list[Vector] = field(default_factory=list)
    truth: list[Vector] = field(default_factory=list)
    compared: int = 0


class VelocityErrors:
    """Errors of an estimated velocity, summed over a log block by block.

    - cutoff: cut-off frequency of the zero-phase velocity [Hz]
    - period: sample period [s]
    """

    def __init__(self, cutoff: float, period: float) -> None:
        self.period = period
        self.cutoff = min(cutoff, 0.4 / period)
        self.sections = scipy.signal.butter(ORDER, self.cutoff, fs=1.0 / period, output="sos")
        self.overlap = math.ceil(REMEMBERED / (self.cutoff * period))
        self.tried = np.geomspace(min(SLOWEST_HZ, 0.01 / period), 1.0 / (math.pi * period), CUTOFFS)
        pairs = np.array([first_order(2.0 * math.pi * tried, period) for tried in self.tried])
        self.pole, self.gain = np.ascontiguousarray(pairs[:, 0]), np.ascontiguousarray(pairs[:, 1])
        self.zero_phase, self.true = self._sums(), self._sums()
        self._begin()

    def take(self, position: Vector, estimate: Vector, truth: Vector | None, follows: bool) -> None:
        """Add the samples (n,) of a block.

        `truth` is the velocity from a simulation or a sensor. It is None either for all blocks of a
        log or for none.
        """
        if not follows:
            self._compare(last=True)
            self._begin()
        self.pending.position.append(position)
        self.pending.estimate.append(estimate)
        if truth is not None:
            self.pending.truth.append(truth)
        if sum(map(len, self.pending.position)) >= self.pending.compared + BLOCK + self.overlap:
            self._compare(last=False)

    def figures(self) -> dict[str, Any]:
        """Return the errors (SI) of the whole log, by name; the errors of a short log are None."""
        self._compare(last=True)
        self._begin()
        filter_figures = self._figures("", self.zero_phase)
        return (
            filter_figures
            | {"zero_phase_cutoff_hz": self.cutoff}
            | (self._figures("_true", self.true) if self.true.samples else {})
        )

    def _sums(self) -> ErrorSums:
        return ErrorSums(np.zeros(2 * self.tried.size + 1))

    def _begin(self) -> None:
        self.pending, self.states = (
            PendingSamples(),
            (np.zeros((3, self.tried.size)), np.zeros((3, self.tried.size))),
        )

    def _compare(self, last: bool) -> None:
        """Add the errors of the pending samples, except those of the last `overlap` samples.

        If `last` is True, add the errors of all pending samples.
        """
        pending = self.pending
        if not pending.position:
            return
        position, estimate = np.concatenate(pending.position), np.concatenate(pending.estimate)
        truth = np.concatenate(pending.truth) if pending.truth else None
        end = position.size if last else position.size - self.overlap
        if position.size < LEAST or end <= pending.compared:
            return
        central = np.gradient(position, self.period)
        reference = scipy.signal.sosfiltfilt(
            self.sections, central, padlen=min(self.overlap, position.size - 1)
        )
        part = slice(pending.compared, end)
        difference = np.diff(position, prepend=position[0])[part] / self.period
        self._add(self.zero_phase, self.states[0], difference, reference[part], estimate[part])
        if truth is not None:
            self._add(self.true, self.states[1], difference, truth[part], estimate[part])
        first = max(0, end - self.overlap)
        self.pending = PendingSamples(
            [position[first:]],
            [estimate[first:]],
            [] if truth is None else [truth[first:]],
            end - first,
        )

    def _add(
        self,
        sums: ErrorSums,
        state: NDArray[np.float64],
        difference: Vector,
        reference: Vector,
        estimate: Vector,
    ) -> None:
        wanted = np.ascontiguousarray(reference)
        low_pass_bank(difference, wanted, self.pole, self.gain, state, sums.low_passes)
        sums.observer += float(np.sum((estimate - wanted) ** 2))
        sums.samples += difference.size

    def _figures(self, ending: str, sums: ErrorSums) -> dict[str, Any]:
        """Return the rms errors, and order (0: unfiltered) and cut-off of the best low-pass."""
        names = [
            f"velocity_rms{ending}",
            f"velocity_rms_filter{ending}",
            f"filter_cutoff_hz{ending}",
            f"filter_order{ending}",
        ]
        if not sums.samples:
            return dict.fromkeys(names)
        best = int(np.argmin(sums.low_passes))
        order = 0 if best == 0 else 1 if best <= self.tried.size else 2
        cutoff = None if order == 0 else float(self.tried[(best - 1) % self.tried.size])
        rms = [
            math.sqrt(total / sums.samples)
            for total in (sums.observer, float(sums.low_passes[best]))
        ]
        return dict(zip(names, (*rms, cutoff, order), strict=True))

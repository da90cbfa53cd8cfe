"""Document `promise.yaml`: half widths of the intervals that one or two tests should reach."""

from __future__ import annotations

from collections.abc import Sequence

from frictool.documents.bench import DRIVE_NOISE_SHARE, Bench
from frictool.documents.promise import HalfWidths, Promise
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Quantity, drive_dimension, si_unit
from frictool.identify.excite.precise_strokes import CONFIDENCE, PreciseTest
from frictool.identify.fit_result import DIMENSIONS

METHOD = "auto"  # method of `identify` in the simulations of the test


def promise_of(
    tests: Sequence[PreciseTest], bench: Bench, noise: float | None, provenance: Provenance
) -> Promise:
    """Return the document `promise.yaml` for the tests of a bench.

    `noise` is the standard deviation of the noise on the measured drive, A | V; the default is
    0.2 % of the drive's limit.
    """
    actuator = bench.actuator
    assumed = DRIVE_NOISE_SHARE * actuator.limit.value if noise is None else noise

    def widths(values: dict[str, float]) -> HalfWidths:
        return HalfWidths(
            **{
                name: Quantity(value, unit=si_unit(DIMENSIONS[name], bench.axis))
                for name, value in values.items()
            }
        )

    merged = [(one.half_widths, one.bounds) for one in tests]
    drive = si_unit(drive_dimension(actuator.drive, constant=False), bench.axis)
    return Promise(
        format="promise/1",
        name=bench.name,
        axis=bench.axis,
        confidence=CONFIDENCE,
        method=METHOD,
        duration=Quantity(sum(one.sequence.duration for one in tests), unit="s"),
        drive_noise=Quantity(assumed, unit=drive),
        half_widths=widths({k: v for one, _ in merged for k, v in one.items()}),
        bounds=widths({k: v for _, one in merged for k, v in one.items()}),
        provenance=provenance,
    )

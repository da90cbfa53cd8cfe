"""`promise.yaml`: precision that a test of `frictool excite --for` should reach."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from frictool.documents.provenance import Provenance
from frictool.documents.quantity import (
    AnyQuantity,
    Axis,
    Inertia,
    NonNegativeEffort,
    PositiveTime,
    Viscous,
)
from frictool.runtime.object_view import ObjectView

Share = Annotated[float, msgspec.Meta(gt=0, lt=1)]


class HalfWidths(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Half width of the interval of each parameter.

    - `inertia`, `viscous`, `coulomb`, `offset`, `breakaway`: Half width, in units of the parameter.
    """

    inertia: Inertia | None = None
    viscous: Viscous | None = None
    coulomb: NonNegativeEffort | None = None
    offset: NonNegativeEffort | None = None
    breakaway: NonNegativeEffort | None = None


class Promise(
    ObjectView, msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True
):
    """Precision that is expected from a test: `promise.yaml`.

    - `name`: Name of the bench.
    - `confidence`: Confidence level of the intervals.
    - `method`: Method of `identify` for which the half widths are valid.
    - `duration`: Duration of the test.
    - `drive_noise`: Assumed standard deviation of the noise of the measured drive.
    - `half_widths`: Promised half width of the confidence interval of each parameter.
    - `bounds`: Half widths that follow from the Cramér-Rao bound. No unbiased estimator has smaller
      half widths.
    """

    format: Literal["promise/1"]
    name: str
    axis: Axis
    confidence: Share
    method: str
    duration: PositiveTime
    drive_noise: AnyQuantity
    half_widths: HalfWidths
    bounds: HalfWidths
    provenance: Provenance

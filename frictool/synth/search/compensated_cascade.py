"""PI cascade with compensation of the model's friction at the speed of the filtered reference.

The cascade suits axes whose friction is a large part of the drive's limit, and whose dead time
allows only a slow speed loop.
"""

from __future__ import annotations

from collections.abc import Mapping

from msgspec import structs

from frictool.documents.design import Design
from frictool.documents.design_blocks import FrictionCompensationDesign
from frictool.documents.quantity import Quantity, si_unit
from frictool.synth.search.candidate_family import CandidateFamily, SearchedParameter, rounded
from frictool.synth.search.design_scales import DesignScales
from frictool.synth.search.pi_cascade import PI_CASCADE, pi_design

CANDIDATES = 450
COMPENSATION = (
    SearchedParameter("compensated_share", 0.1, 1.5, (0.5, 0.9)),
    SearchedParameter("smoothing_share", 0.01, 2.0, (0.2, 0.1)),
)


def compensated_design(scales: DesignScales, values: Mapping[str, float]) -> Design:
    """Return the design with the dimensionless parameters `values`, scaled by `scales`."""
    unit = si_unit("velocity", scales.bench.axis)
    smoothing = values["smoothing_share"] * scales.step / scales.response
    return structs.replace(
        pi_design(scales, values),
        friction_compensation=FrictionCompensationDesign(
            source="model",
            velocity="reference",
            smoothing_speed=Quantity(value=rounded(smoothing), unit=unit),
            gain=rounded(values["compensated_share"]),
        ),
    )


COMPENSATED_CASCADE = CandidateFamily(
    "PI cascade with friction added by the reference",
    (*PI_CASCADE.parameters, *COMPENSATION),
    compensated_design,
    CANDIDATES,
)

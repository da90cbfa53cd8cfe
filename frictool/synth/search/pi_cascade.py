"""Cascade of a position law and a PI controller of the speed: the simplest family of designs.

The controller gain is the same for all plants. omega_h is the crossover frequency of the speed loop
with the plant that has the largest acceleration per unit of the drive, omega_l with the plant that
has the smallest. The gain and the integral time follow from two products, which the search varies:

    gain_product        omega_h (dead time + 1/(bandwidth of the speed filter))
    integral_product    omega_l (integral time)
"""

from __future__ import annotations

from collections.abc import Mapping

from frictool.documents.design import Design
from frictool.documents.pid_gains import Pid
from frictool.documents.quantity import Quantity, si_unit
from frictool.documents.weights import Weights
from frictool.synth.search import position_blocks
from frictool.synth.search.candidate_family import CandidateFamily, SearchedParameter, rounded
from frictool.synth.search.design_scales import DesignScales

CANDIDATES = 600
LOOP = (
    SearchedParameter("gain_product", 0.1, 0.95, (0.4, 0.5)),
    SearchedParameter("integral_product", 1.5, 60.0, (6.0, 14.0)),
)


def pi_design(scales: DesignScales, values: Mapping[str, float]) -> Design:
    """Return the design with the dimensionless parameters `values`, scaled by `scales`."""
    bench = scales.bench
    filtered = position_blocks.velocity(scales, values)
    assert filtered.filter_rad_s
    crossover = values["gain_product"] / (scales.dead_time + 1.0 / filtered.filter_rad_s)
    low, high = scales.gain
    gain = crossover / high * bench.actuator.constant.value
    return Design(
        format="design/1",
        name=bench.name,
        axis=bench.axis,
        structure="speed_cascade",
        method="pid",
        weights=Weights(),
        pid=Pid(
            speed_gain=Quantity(value=rounded(gain), unit=si_unit("viscous", bench.axis)),
            integral_time_s=rounded(values["integral_product"] * high / (low * crossover)),
        ),
        position_law=position_blocks.position_law(scales, values),
        velocity=filtered,
        prefilter=position_blocks.prefilter(scales, values),
    )


PI_CASCADE = CandidateFamily(
    "PI cascade", (*position_blocks.PARAMETERS, *LOOP), pi_design, CANDIDATES
)

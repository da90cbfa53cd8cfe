"""Cascade of a position law and a speed controller by matrix inequalities (`lft_lpv`).

The weights come from `configs/clutch/designs/fast.yaml`, a design for the clutch of annex C of the
thesis. They are scaled by time, speed and encoder count. The search varies the factors `bandwidth`
and `softness`:

    t_s   response/0.22 s                v_s   (step/response)/227, in rad/s or m/s
    W2 bandwidth   40 bandwidth/t_s      drive, command    25 softness v_s/limit
    disturbance    0.03/v_s              noise             0.01 softness clip(q, 0.1, 1) step/50
    channel        0.03 F

t_s and v_s are the scales of time and speed, relative to the clutch. `response` is the specified
response time, `step` the longest step of the reference, `limit` the drive's limit, F the Coulomb
friction, and q the quotient (encoder count)/step, relative to the quotient of the clutch. Softness
and bandwidth are rounded to powers of 2, so that few sets of inequalities must be solved.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from frictool.documents.design import Design
from frictool.documents.quantity import Quantity, si_unit
from frictool.documents.weights import Weights
from frictool.synth.search import position_blocks
from frictool.synth.search.candidate_family import CandidateFamily, SearchedParameter, rounded
from frictool.synth.search.design_scales import DesignScales

CANDIDATES = 250
RESPONSE, SPEED, STEP, COUNT = 0.22, 227.0, 50.0, 0.1122  # clutch [s, rad/s, rad, rad]
BANDWIDTH, DISTURBANCE, DRIVE, NOISE = 40.0, 0.03, 25.0, 0.01
CHANNEL = 0.03  # unit of the uncertainty channel, as a share of the Coulomb friction
STARTS = {
    "braking_share": (0.33, 0.3),
    "band_share": (0.7, 0.8),
    "rest_share": (0.2, 0.1),
    "settled_share": (0.03, 0.17),
    "prefilter_product": (7.15, 8.0),
    "damping": (0.83, 1.0),
    "velocity_product": (0.75, 4.0),
}
LOOP = (
    SearchedParameter("bandwidth", 0.35, 2.9, (1.0, 1.0)),
    SearchedParameter("softness", 0.17, 5.7, (1.0, 0.5)),
)


def lpv_design(scales: DesignScales, values: Mapping[str, float]) -> Design:
    """Return the design with the dimensionless parameters `values`, scaled by `scales`."""
    bench = scales.bench
    time = scales.response / RESPONSE
    speed = scales.step / scales.response / SPEED
    softness, bandwidth = _level(values["softness"]), _level(values["bandwidth"])
    effort = rounded(DRIVE * softness * speed / bench.actuator.limit.value)
    coarse = float(np.clip(scales.count / scales.step / (COUNT / STEP), 0.1, 1.0))
    noise = rounded(NOISE * coarse * softness * scales.step / STEP)
    friction = scales.friction * bench.mechanics.inertia.value
    return Design(
        format="design/1",
        name=bench.name,
        axis=bench.axis,
        structure="speed_cascade",
        method="lft_lpv",
        schedule=("viscous", "coulomb"),
        channel_effort=rounded(CHANNEL * friction) if friction > 0.0 else None,
        weights=Weights(
            bandwidth_rad_s=rounded(BANDWIDTH * bandwidth / time),
            disturbance=rounded(DISTURBANCE / speed),
            drive=effort,
            command=effort,
            noise=Quantity(value=noise, unit=si_unit("position", bench.axis)),
        ),
        position_law=position_blocks.position_law(scales, values),
        velocity=position_blocks.velocity(scales, values),
        prefilter=position_blocks.prefilter(scales, values),
    )


def _level(value: float) -> float:
    return 2.0 ** round(math.log2(value))


LPV_CASCADE = CandidateFamily(
    "LPV cascade",
    (
        *(replace(one, starts=STARTS[one.name]) for one in position_blocks.PARAMETERS),
        *LOOP,
    ),
    lpv_design,
    CANDIDATES,
)

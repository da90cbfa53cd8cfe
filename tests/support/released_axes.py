"""Clutches that are released inside the set of a proof of rest, and how far they move."""

from __future__ import annotations

import numpy as np

from frictool.adapters.axis_model import axis_of
from frictool.documents.certificate import RestProof
from frictool.documents.controller import Controller
from frictool.engine.axis_motion import advance
from frictool.plant import axis as ax
from studies.rigs.clutch_model import clutch_model

SEED = 20261127
START = 30.0  # rad


def furthest_release(controller: Controller, proof: RestProof, count: int) -> float:
    """Return the largest motion of `count` released axes relative to the band less one count.

    Asserts that each axis has stopped at the end of the proved time, and that the proved
    disturbance does not move it again.
    """
    law, certificate = controller.position_law, controller.certificate
    assert law is not None
    assert certificate is not None
    random = np.random.default_rng(SEED)
    furthest = 0.0
    for _ in range(count):
        drawn = {
            key: random.choice(
                [*getattr(certificate.box, key), random.uniform(*getattr(certificate.box, key))]
            )
            for key in ("inertia", "viscous", "coulomb", "constant")
        }
        p = axis_of(clutch_model(), **drawn).as_array()
        p[ax.OFFSET] = random.choice([-1.0, 1.0]) * proof.stopping_disturbance
        state = ax.rest(START)
        state[ax.GAP] = random.uniform(-0.5, 0.5) * p[ax.BACKLASH]
        # the whole speed of the proof, split between motion and a drive that decays
        share = random.uniform(-1.0, 1.0)
        sign = random.choice([-1.0, 1.0])
        state[ax.VELOCITY] = sign * abs(share) * proof.speed
        state[ax.DRIVE] = (
            random.choice([-1.0, 1.0])
            * (1.0 - abs(share)) * proof.speed * p[ax.INERTIA] / (p[ax.CONSTANT] * p[ax.LAG])
        )  # fmt: skip
        wait = proof.stop_time_s + 40.0 * p[ax.LAG]
        for _ in range(20):
            assert advance(state, 0.0, p, wait / 20.0) == 0
            furthest = max(furthest, abs(state[ax.POSITION] - START))
        assert state[ax.VELOCITY] == 0.0
        p[ax.OFFSET] = random.choice([-0.999, 0.999]) * proof.disturbance
        before = float(state[ax.POSITION])
        assert advance(state, 0.0, p, 1.0) == 0
        assert state[ax.POSITION] == before
    return furthest / (law.band - controller.bench.encoder.resolution)

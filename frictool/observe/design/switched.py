"""Design of a switched observer from its modes: gains, rounding, and verification."""

from __future__ import annotations

from typing import Literal

import msgspec
import numpy as np

from frictool.documents.model import Model
from frictool.documents.observer import FrictionMap, Mode, Observer, Row, Switched
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Quantity, si_unit
from frictool.lmi.quiet_observer_gains import quiet_gains
from frictool.lmi.switched_observer_gains import ObserverMode, SwitchedGains, switched_gains
from frictool.observe.design.mode_matrices import ModeConstants, subsystem
from frictool.observe.design.mode_transitions import Switch
from frictool.observe.design.switched_settings import (
    SwitchedObserverSettings,
    decay_of,
    switch_speed_of,
)
from frictool.observe.design.verification import motion_samples, verify
from frictool.typing import Matrix

DIGITS = 10  # number of significant digits of a stored gain


def facts_of(
    model: Model,
    settings: SwitchedObserverSettings,
    friction: FrictionMap,
    wear: Literal["multiplicative", "additive"],
) -> ModeConstants:
    """Return the constants that all modes of the observer have in common."""
    inertia = settings.inertia if settings.inertia is not None else model.parameters.inertia.value
    return ModeConstants(
        wear,
        model.bench.sample_period_s,
        inertia,
        friction.viscous,
        settings.stuck_speed,
        settings.weights,
    )


def design_switched(
    model: Model,
    settings: SwitchedObserverSettings,
    provenance: Provenance,
    facts: ModeConstants,
    friction: FrictionMap,
    modes: list[Mode],
    allowed: tuple[Switch, ...],
) -> Observer:
    """Design a switched observer with verified gains for `modes`.

    Raises NoSolutionError if the inequalities have no solution or the gains fail the verification.
    """
    posed = {
        mode.index: subsystem(facts, mode.direction, mode.friction, mode.deviation)
        for mode in modes
    }
    solution, noise_gain = _synthesised(posed, allowed, decay_of(model, settings), settings.quiet)
    gains = {index: _rounded(each) for index, each in solution.gains.items()}
    # in mode 0 the estimate of alpha is constant, so that the position must not correct it
    gains[0][2, 0] = 0.0
    proved = verify(posed, allowed, gains, solution)
    stored = tuple(
        msgspec.structs.replace(
            mode, gains=_rows(gains[mode.index]), spectral_radius=proved.radii[mode.index]
        )
        for mode in modes
    )
    switched = Switched(
        wear=facts.wear,
        switch_speed=Quantity(
            switch_speed_of(model, settings), unit=si_unit("velocity", model.axis)
        ),
        weights=settings.weights,
        modes=stored,
        transitions=allowed,
        gamma=proved.gamma,
        decay=solution.decay,
        stuck_speed=settings.stuck_speed,
        switching_radius=proved.switching_radius,
        simulated_gain=proved.simulated_gain,
        smallest_gamma=solution.smallest_gamma,
        motion_after_rest_s=_seconds(motion_samples(proved.rest, solution.decay), facts.period),
        motion_after_turn_s=_seconds(motion_samples(proved.turn, solution.decay), facts.period),
        quiet=settings.quiet,
        noise_gain=noise_gain,
    )
    return Observer(
        "observer/1",
        model.name,
        model.axis,
        facts.period,
        Quantity(facts.inertia, unit=si_unit("inertia", model.axis)),
        friction,
        model.bench,
        provenance,
        switched=switched,
    )


def _synthesised(
    posed: dict[int, ObserverMode], allowed: tuple[Switch, ...], decay: float, quiet: float | None
) -> tuple[SwitchedGains, float | None]:
    if quiet is None:
        return switched_gains(posed, allowed, decay), None
    # only the measured position has noise; in mode 0, the second measurement is the estimate of
    # alpha
    noise = {index: np.eye(len(mode.c))[0] for index, mode in posed.items()}
    # in mode 0 the estimate of alpha is constant, so that the position must not correct it
    stuck = np.array([[True, False], [True, False], [False, True]])
    solution = quiet_gains(posed, allowed, noise, decay, quiet, {0: stuck})
    return solution.gains, solution.noise_gain


def _seconds(samples: float | None, period: float) -> float | None:
    return None if samples is None else samples * period


def _rounded(gains: Matrix) -> Matrix:
    return np.array([[float(f"{value:.{DIGITS - 1}e}") for value in row] for row in gains])


def _rows(gains: Matrix) -> tuple[Row, ...]:
    return tuple(tuple(float(value) + 0.0 for value in row) for row in gains)

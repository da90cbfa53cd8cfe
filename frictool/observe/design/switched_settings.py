"""Settings of the design of a switched observer."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from frictool.documents.model import Model
from frictool.documents.quantity import si_unit
from frictool.errors import NoSolutionError

Transitions = Literal["neighbours", "direction"]

# decay factor of the error in a sample of DECAY_PERIOD [s] or longer; for shorter samples, the time
# constant of the error stays 0.333 s
DECAY, DECAY_PERIOD = 0.997, 1e-3
SLOW = 1.0 / 40.0  # default of Sigma relative to the top speed (clutch: 10 rad/s and 400 rad/s)


@dataclass(frozen=True)
class SwitchedObserverSettings:
    """Options of `observe design`; an option that is None is derived from the model.

    - intervals: number of position intervals of each direction, if friction varies with position
    - switch_speed: speed Sigma below which the axis is treated as stuck [rad/s | m/s]
    - weights: weights of the errors of position, speed and wear alpha
    - decay: largest factor lambda by which the error is multiplied in each sample
    - inertia: inertia that replaces the model's inertia [kg m2 | kg]
    - transitions: allowed transitions of a moving axis: `neighbours`, to the next interval in the
      direction of motion; `direction`, to any interval of the same direction
    - stuck_speed: factor, 0 to 1, by which each sample of mode 0 (stuck) multiplies the estimated
      speed (thesis 6.18)
    - quiet: allowed bound gamma of the error, divided by the smallest possible gamma. With a larger
      value, the gains pass less encoder noise (lmi/quiet_observer_gains.py). None selects the
      smallest gamma.
    """

    intervals: int = 10
    switch_speed: float | None = None
    weights: tuple[float, float, float] = (1.0, 100.0, 0.001)
    decay: float | None = None
    inertia: float | None = None
    transitions: Transitions = "neighbours"
    stuck_speed: float = 1.0
    quiet: float | None = None

    def __post_init__(self) -> None:
        """Raise ValueError if `stuck_speed` or `weights` is out of range."""
        if not 0.0 <= self.stuck_speed <= 1.0:
            raise ValueError(f"stuck_speed: found {self.stuck_speed:g}; allowed: 0 to 1")
        if min(self.weights) < 0.0 or self.weights[1] <= 0.0:
            raise ValueError(
                f"weights: found {', '.join(f'{w:g}' for w in self.weights)}; "
                "allowed: all >= 0, and the weight of the speed > 0"
            )


class UnsuitableSetting(NoSolutionError):
    """Error for a setting, such as an option of a command, that is impossible with the model."""


def decay_of(model: Model, settings: SwitchedObserverSettings) -> float:
    """Return the factor lambda by which the estimation error decays per sample.

    If the settings contain no decay, and the sample period is at most DECAY_PERIOD, lambda is
    DECAY^(period/DECAY_PERIOD). The time constant then does not depend on the period. For longer
    periods, lambda is DECAY, because a smaller lambda makes the bound gamma of the error larger.
    """
    return (
        settings.decay
        if settings.decay is not None
        else math.pow(DECAY, min(1.0, model.bench.sample_period_s / DECAY_PERIOD))
    )


def switch_speed_of(model: Model, settings: SwitchedObserverSettings) -> float:
    """Return the speed Sigma [rad/s | m/s] below which the axis is treated as stuck.

    Raises NoSolutionError if neither the settings nor the top speed in bench.yaml determine Sigma.
    Raises UnsuitableSetting if the Sigma in the settings is not below the top speed.
    """
    top = model.bench.mechanics.top_speed
    unit = si_unit("velocity", model.axis)
    if settings.switch_speed is not None:
        if top is not None and settings.switch_speed >= top.value:
            raise UnsuitableSetting(
                f"switch speed: found {settings.switch_speed:g} {unit}; allowed: below the bench's "
                f"mechanics.top_speed, {top.value:g} {unit}; the default is top_speed/40"
            )
        return settings.switch_speed
    if top is None:
        raise NoSolutionError(
            "the switch speed is unknown: by default it is mechanics.top_speed/40, but the bench "
            f"has no mechanics.top_speed; give --switch-speed, such as 10{unit.replace(' ', '')}"
        )
    return SLOW * top.value

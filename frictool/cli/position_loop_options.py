"""Options of `validate` and `simulate` for the gains of the rig's position controller."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import click

from frictool.cli.common_options import FiniteRange

if TYPE_CHECKING:
    from frictool.documents.bench import Bench
    from frictool.engine.bench_position_loop import PositionServo

LAW = "drive = speed gain (position gain (reference - position) - speed) + integral"
F = TypeVar("F", bound=Callable[..., object])
positive = FiniteRange(0.0, min_open=True)
OPTIONS = (
    click.option(
        "--position-gain",
        type=positive,
        help="Position gain of the bench's controller [1/s]; needs --speed-gain.",
    ),
    click.option(
        "--speed-gain",
        type=positive,
        help=("Speed gain of the bench's controller, drive per speed; needs --position-gain."),
    ),
    click.option(
        "--integral-gain",
        type=positive,
        help=("Integral gain of the bench's controller, drive per position error and second."),
    ),
)


class ServoGains(NamedTuple):
    """Gains of the rig's position controller in SI; None for a gain that is not set."""

    position: float | None
    speed: float | None
    integral: float | None

    @property
    def closed(self) -> bool:
        """Return True if position and speed gain are set, False if no gain is set.

        Raises UsageError for any other combination of gains.
        """
        if (self.position is None) != (self.speed is None) or (
            self.integral is not None and self.speed is None
        ):
            raise click.UsageError(
                "--position-gain and --speed-gain belong together; give both, or none. "
                "--integral-gain needs both."
            )
        return self.speed is not None

    def servo(self, bench: Bench) -> PositionServo:
        """Return the position controller for the bench's drive; it outputs an effort [N m | N]."""
        return self.on_drive(bench.actuator.constant.value, bench.actuator.limit.value)

    def on_drive(self, constant: float, limit: float) -> PositionServo:
        """Return the position controller for any drive; it outputs an effort [N m | N].

        - constant: effort per unit of the drive [A | V]
        - limit: limit of the drive [A | V]
        """
        from frictool.engine.bench_position_loop import PositionServo

        position, speed = self.position or 0.0, self.speed or 0.0
        return PositionServo(
            proportional=constant * speed * position,
            integral=constant * (self.integral or 0.0),
            derivative=constant * speed,
            limit=constant * limit,
        )


def servo_options(command: F) -> F:
    """Add the options of the position loop's gains to a command."""
    for option in reversed(OPTIONS):
        command = option(command)
    return command

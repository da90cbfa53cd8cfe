"""The gains of the position loop that a bench runs, as options: `validate` and `simulate` mean the
same by them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import click

from frictool.cli.output import FiniteRange

if TYPE_CHECKING:
    from frictool.documents.bench import Bench
    from frictool.engine.servo import PositionServo

LAW = "drive = speed gain (position gain (reference - position) - speed) + integral"
F = TypeVar("F", bound=Callable[..., object])
positive = FiniteRange(0.0, min_open=True)
OPTIONS = (
    click.option(
        "--position-gain", type=positive, help="Of the bench's controller [1/s]; with --speed-gain."
    ),
    click.option(
        "--speed-gain",
        type=positive,
        help="Of the bench's controller, drive per speed; with --position-gain.",
    ),
    click.option(
        "--integral-gain", type=positive, help="Of the position's error, drive per position and s."
    ),
)


class ServoGains(NamedTuple):
    """As given, in SI."""

    position: float | None
    speed: float | None
    integral: float | None

    @property
    def given(self) -> bool:
        """Whether there is a controller at all. Raises UsageError where it is half of one."""
        if (self.position is None) != (self.speed is None) or (
            self.integral is not None and self.speed is None
        ):
            raise click.UsageError(
                "a controller has both --position-gain and --speed-gain; give both, or none."
            )
        return self.speed is not None

    def servo(self, bench: Bench) -> PositionServo:
        """The same from position to effort, limited as the bench's drive."""
        return self.on_drive(bench.actuator.constant.value, bench.actuator.limit.value)

    def on_drive(self, constant: float, limit: float) -> PositionServo:
        """The same for a drive of so much effort per unit, and its limit."""
        from frictool.engine.servo import PositionServo

        position, speed = self.position or 0.0, self.speed or 0.0
        return PositionServo(
            proportional=constant * speed * position,
            integral=constant * (self.integral or 0.0),
            derivative=constant * speed,
            limit=constant * limit,
        )


def servo_options(command: F) -> F:
    """Adds the options to a command."""
    for option in reversed(OPTIONS):
        command = option(command)
    return command

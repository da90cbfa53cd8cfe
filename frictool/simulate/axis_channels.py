"""Log stream of a closed-loop simulation, with channels that no real bench could measure.

============================  ====================================================================
channel                       meaning
============================  ====================================================================
position                      output of the encoder, with its faults
reference                     reference of the position
profile                       profile that the loop tracked, if the controller generates a profile
current | voltage             output of the drive's sensor, with its faults and noise
effort                        measured drive times the nominal constant, also for variants with
                              another constant
velocity_estimated            speed that the controller used, from the difference of encoder
                              readings or an observer
velocity_measured             output of an exact velocity sensor, if the controller uses the sensor
command                       output of the controller; acts `delay_samples` samples later
position_true, velocity       true position and velocity of the motor
load_position                 true position behind the backlash
current_true | voltage_true   true drive; if a drive without lag jumps at the sample, the value
                              after the jump
disturbance                   mean external effort over the sample, if a disturbance acts
..._factor                    factor of the dry friction, the viscous friction or the drive
                              constant, if the scenario has a drift of this parameter; a friction
                              factor includes the effect of temperature
temperature                   temperature, if the scenario states it
position_valid                1 if the encoder gives a position, else 0; only if a sample is invalid
controller_fault              1 in the controller's fault state, else 0; only if a sample is invalid
                              or the scenario has commands of a supervisor
============================  ====================================================================
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np

from frictool.documents.quantity import CHANNEL_DIMENSIONS, drive_dimension, si_unit
from frictool.documents.scenario import Scenario
from frictool.engine import closed_loop
from frictool.engine.disturbances_and_faults import (
    CONSTANT_FACTOR,
    DISTURBANCE,
    FRICTION,
    SENSOR_GAIN,
    SENSOR_OFFSET,
    VISCOUS_FACTOR,
)
from frictool.logs.log import Stream
from frictool.simulate.rig import Rig
from frictool.simulate.scenario_conditions import on_axis
from frictool.typing import Vector

NO_UNIT = "1"


class ControllerSignals(NamedTuple):
    """Internal signals of a controller, each (n,); None if the controller has no such signal.

    - speed: speed estimate that the control law used
    - profile: reference profile that the control loop tracked
    - fault: 1 while the controller is in its fault state, else 0. If the scenario has no supervisor
      commands, `fault` is None, and AxisChannels computes the fault from the measured positions
    """

    speed: Vector | None = None
    profile: Vector | None = None
    fault: Vector | None = None


NO_SIGNALS = ControllerSignals()


class AxisChannels:
    """Builder of log streams, one for each plant variant that is simulated in a scenario.

    - samples: number n of samples
    - reference: reference (n,) of the position; None without a controller
    - conditions: disturbances, drifts and sensor faults (n, 8), as in
      engine/disturbances_and_faults.py; (0, 8) if the scenario has none of these
    - senses_velocity: True if the controller uses a velocity sensor
    - hold_samples: number of successive invalid samples that the controller tolerates
      (control/measurement_guard.py)
    """

    def __init__(
        self,
        rig: Rig,
        scenario: Scenario,
        samples: int,
        reference: Vector | None,
        conditions: Vector,
        senses_velocity: bool = False,
        hold_samples: int = 0,
    ) -> None:
        self.rig = rig
        self.reference = reference
        self.senses_velocity = senses_velocity
        self.hold_samples = hold_samples
        self.noise, self.seed = scenario.drive_noise, scenario.seed
        self.time: Vector = np.arange(samples, dtype=np.float64) * rig.sample_period_s
        self.gain: Vector | float = conditions[:, SENSOR_GAIN] if conditions.size else 1.0
        self.offset: Vector | float = conditions[:, SENSOR_OFFSET] if conditions.size else 0.0
        self._happening = partial(_happening, scenario, conditions)

    def stream(
        self,
        topic: str,
        index: int,
        record: Vector,
        values: ControllerSignals = NO_SIGNALS,
        *,
        judged: bool = False,
    ) -> Stream:
        """Return the log stream of the variant with number `index`.

        - record: simulated signals (n, 7) with the columns of engine/closed_loop.py
        - values: internal signals of the controller
        - judged: True if only metrics read the stream, so that other signals are left out (effort,
          true drive, true position of the motor, disturbance, drifts, temperature)

        The measurement noise of the drive is drawn with the seed (scenario seed, index).
        """
        drive = self.rig.drive
        noise = self.drive_noise(index)
        true_drive, velocity = (
            record[:, closed_loop.TRUE_DRIVE],
            record[:, closed_loop.TRUE_VELOCITY],
        )
        shown: Vector = self.gain * true_drive + self.offset + noise
        of_drive = "effort" if drive == "effort" else drive_dimension(drive, constant=False)
        columns: dict[str, tuple[Vector, str]] = {
            "position": (self._shown(record), "position"),
            **({} if self.reference is None else {"reference": (self.reference, "position")}),
            drive: (shown, CHANNEL_DIMENSIONS[drive]),
            **({} if judged else {"effort": (self.rig.constant * shown, "effort")}),
            "command": (record[:, closed_loop.COMMAND], of_drive),
            "velocity": (velocity, "velocity"),
            **(
                {}
                if judged
                else {"position_true": (record[:, closed_loop.TRUE_POSITION], "position")}
            ),
            "load_position": (record[:, closed_loop.LOAD], "position"),
            **({} if judged else {f"{drive}_true": (true_drive, of_drive)}),
        }
        if self.senses_velocity:
            columns["velocity_measured"] = (velocity, "velocity")
        if values.speed is not None:
            columns["velocity_estimated"] = (values.speed, "velocity")
        if values.profile is not None:
            columns["profile"] = (values.profile, "position")
        if not judged:
            columns |= self._happening()
        columns |= self._invalid(record[:, closed_loop.MEASURED])
        if values.fault is not None:
            columns["controller_fault"] = (values.fault, NO_UNIT)
        signals = {
            name: np.ascontiguousarray(column, dtype=np.float64)
            for name, (column, _) in columns.items()
        }
        units = {name: self._unit(dimension) for name, (_, dimension) in columns.items()}
        return Stream(topic, self.time, signals, units)

    def drive_noise(self, index: int) -> Vector:
        """Return the measurement noise (n,) of the drive for variant number `index`."""
        if self.noise == 0.0:
            return np.zeros(self.time.size)
        generator = np.random.Generator(np.random.PCG64([self.seed, index]))
        return generator.normal(0.0, self.noise, self.time.size)

    def _shown(self, record: Vector) -> Vector:
        """Return the measured position (n,); an invalid sample repeats the last valid sample."""
        measured = record[:, closed_loop.MEASURED]
        valid = np.isfinite(measured)
        if valid.all():
            return measured
        last = np.maximum.accumulate(np.where(valid, np.arange(valid.size), -1))
        before = closed_loop.measure(
            float(record[0, closed_loop.TRUE_POSITION]), self.rig.resolution
        )
        return np.where(last >= 0, measured[last], before)

    def _invalid(self, measured: Vector) -> dict[str, tuple[Vector, str]]:
        valid = np.isfinite(measured)
        if valid.all():
            return {}
        index = np.arange(valid.size)
        in_a_row = index - np.maximum.accumulate(np.where(valid, index, -1))
        channels = {"position_valid": (valid.astype(np.float64), NO_UNIT)}
        if self.reference is not None:
            channels["controller_fault"] = (
                np.maximum.accumulate(in_a_row > self.hold_samples).astype(np.float64),
                NO_UNIT,
            )
        return channels

    def _unit(self, dimension: str) -> str:
        if dimension == NO_UNIT:
            return dimension
        return si_unit(dimension, self.rig.effort_axis if dimension == "effort" else self.rig.axis)


def fault_warning(stream: Stream, hold_samples: int) -> list[str]:
    """Return a warning in a list if the controller entered its fault state, else an empty list.

    hold_samples: number of successive invalid samples that the controller tolerates.
    """
    fault = stream.signals.get("controller_fault")
    if fault is None or not fault.any():
        return []
    begin = float(stream.time[int(np.argmax(fault))])
    if "position_valid" not in stream.signals:
        return [
            f"{stream.topic}: a command sets the controller's fault at {begin:.6g} s; the drive is "
            "then 0"
        ]
    lost = f"more than {hold_samples} sample{'s' * (hold_samples != 1)} without a valid position"
    return [
        f"{stream.topic}: the controller reports a fault at {begin:.6g} s, after {lost}; the drive "
        "is then 0"
    ]


def _happening(scenario: Scenario, conditions: Vector) -> dict[str, tuple[Vector, str]]:
    channels: dict[str, tuple[Vector, str]] = {}
    if on_axis(scenario):
        channels["disturbance"] = (np.ascontiguousarray(conditions[:, DISTURBANCE]), "effort")
    for name, column in (
        ("friction", FRICTION),
        ("viscous", VISCOUS_FACTOR),
        ("constant", CONSTANT_FACTOR),
    ):
        if scenario.drifts is not None and getattr(scenario.drifts, name):
            channels[f"{name}_factor"] = (np.ascontiguousarray(conditions[:, column]), NO_UNIT)
    if scenario.temperature is not None:
        constant = np.full(conditions.shape[0], scenario.temperature.value)
        channels["temperature"] = (constant, CHANNEL_DIMENSIONS["temperature"])
    return channels

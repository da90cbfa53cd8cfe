"""Simulated runs of many clutches with different plants and wear, as the logs of a fleet.

    Unit ──axis──▶ engine/closed_loop.py, sample by sample ──encoder, current with noise──▶ Piece

The plant is configs/clutch/nonlinear.yaml, as in the second test of thesis 6.3.2: an encoder with
56 counts per turn, backlash, viscous friction above 260 rad/s (4.4.2.2). Estimators get the model
`believed()`, whose inertia is 20 % below the nominal value. The controllers in controllers/ are
designs/speed.yaml and laws/linear.yaml (a PID) of configs/clutch, designed for nonlinear.yaml,
without certificates. The command

    python -m studies.rigs.clutch_fleet SPEED LINEAR

writes them from two controllers of `frictool synth`.
"""

from __future__ import annotations

import functools
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import msgspec
import numpy as np

from frictool.adapters.axis_model import axis_of
from frictool.adapters.controller_composition import controller_program
from frictool.control.compiled_program import (
    CompiledProgram,
    compile_program,
    control_step,
    copy_program,
    start_at,
)
from frictool.documents.controller import Controller
from frictool.documents.model import Model
from frictool.documents.registry import load
from frictool.documents.writing import to_yaml
from frictool.engine.closed_loop import (
    MEASURED,
    RECORD_SIZE,
    TRUE_DRIVE,
    TRUE_VELOCITY,
    advance_sample,
    encoder_reading,
    measure,
)
from frictool.engine.disturbances_and_faults import FRICTION, neutral
from frictool.engine.status_codes import OK
from frictool.friction.position_polynomial import normalise
from frictool.observe.motion_block import MotionBlock
from frictool.observe.wear_estimate import Kind
from frictool.plant.axis import (
    BACKLASH_BREAKAWAY_RATIO,
    ENCODER_STEP,
    POSITION,
    VELOCITY,
    AxisParameters,
    rest,
)
from frictool.plant.axis_friction_laws import AxisFrictionLevels, FrictionPositionShape
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

Loop = Literal["speed", "linear"]
CLUTCH, CONTROLLERS = Path("configs/clutch/nonlinear.yaml"), Path(__file__).parent / "controllers"
ROOT = Path(__file__).parents[2]
UNSURE = 0.8  # inertia of the estimators' model divided by the true inertia (6.3.2)
NOISE = 0.5  # A, standard deviation
SECONDS, HOLD = 20.0, 0.5
EDGE = 30.0  # rad: position beyond which wear by zone acts
UNITS_STREAM, NOISE_STREAM, TARGETS_STREAM = 101, 102, 103  # second seeds of random numbers


@dataclass(frozen=True)
class Unit:
    """One clutch: factors on the parameters of nonlinear.yaml, and wear.

    - wear: factor of all dry friction, including that inside the backlash, from `since` [s] on
    - zone: factor of all dry friction beyond the motor position EDGE, from `since` [s] on
    - added: added friction in both directions, outside the backlash [N m]
    - forward, backward: factor for one direction, outside the backlash
    - late: delay of the logged current in samples
    - plain_viscous: viscous friction at every speed [N m s/rad]
    - counts: encoder counts per turn; None for the bench's

    All factors but `wear` and `zone` act from the start.
    """

    wear: float = 1.0
    added: float = 0.0
    forward: float = 1.0
    backward: float = 1.0
    zone: float = 1.0
    since: float = 0.0
    inertia: float = 1.0
    viscous: float = 1.0
    gap_friction: float = 1.0
    gap: float = 1.0
    constant: float = 1.0
    plain_viscous: float = 0.0
    late: int = 0
    counts: float | None = None

    @property
    def kind(self) -> Kind:
        """Return the kind of wear of a unit that has at most one kind."""
        if self.added != 0.0:
            return "additive"
        if self.forward != self.backward:
            return "directional"
        if self.zone != 1.0:
            return "zones"
        return "none" if self.wear == 1.0 else "multiplicative"


@dataclass(frozen=True)
class Run:
    """Log of a unit in pieces, and the true velocity (n,) [rad/s]."""

    unit: Unit
    pieces: tuple[MotionBlock, ...]
    velocity: Vector


@functools.cache
def clutch() -> Model:
    """Return the true model of the plant."""
    return load(ROOT / CLUTCH, Model)


@functools.cache
def believed() -> Model:
    """Return the model for estimators, with an inertia 20 % below nominal, and a wider range."""
    model = clutch()
    inertia = model.parameters.inertia
    low, high = inertia.interval
    wrong = msgspec.structs.replace(
        inertia, value=UNSURE * inertia.value, low=UNSURE * low, high=high
    )
    return msgspec.structs.replace(
        model, parameters=msgspec.structs.replace(model.parameters, inertia=wrong)
    )


def with_encoder(model: Model, counts: float | None) -> Model:
    """Return the model with an encoder of `counts` per turn; None keeps its encoder."""
    if counts is None:
        return model
    encoder = msgspec.structs.replace(model.bench.encoder, counts_per_revolution=counts)
    return msgspec.structs.replace(
        model, bench=msgspec.structs.replace(model.bench, encoder=encoder)
    )


def spread(seed: int, **fields: Any) -> Unit:
    """Return a random unit.

    The spread is +-50 % for viscous friction, +-40 % for friction inside the backlash, and +-20 %
    for the inertia and the width of the backlash.
    """
    draw = np.random.Generator(np.random.PCG64([seed, UNITS_STREAM])).uniform(-1.0, 1.0, 4)
    viscous, gap_friction, gap, inertia = (
        float(1.0 + width * part) for width, part in zip((0.5, 0.4, 0.2, 0.2), draw, strict=True)
    )
    return replace(
        Unit(viscous=viscous, gap_friction=gap_friction, gap=gap, inertia=inertia), **fields
    )


def axis(unit: Unit) -> AxisParameters:
    """Return the axis of a unit without `wear` and `zone`, which `worn_loop` applies."""
    plain = axis_of(with_encoder(clutch(), unit.counts))
    laws, loose = plain.laws, unit.gap_friction * plain.backlash_coulomb
    assert laws.shape is not None
    assert laws.backward is not None
    ratio, low, high = plain.breakaway / plain.coulomb, laws.shape.low, laws.shape.high
    curves, levels = [], []
    for own, terms, factor in zip(
        (plain.coulomb, laws.backward.coulomb),
        laws.shape.coulomb,
        (unit.forward, unit.backward),
        strict=True,
    ):
        curve = factor * own * normalise(np.array(terms), low, high)[0]
        curve[0] += unit.added
        curves.append(tuple(map(float, curve)))
        levels.append(normalise(curve, low, high)[1])
    viscous = unit.plain_viscous
    laws = laws._replace(
        backward=AxisFrictionLevels(viscous, levels[1], ratio * levels[1]),
        shape=FrictionPositionShape(low, high, (curves[0], curves[1]), (curves[0], curves[1])),
        regimes=tuple(
            r._replace(
                forward=viscous + unit.viscous * r.forward,
                backward=viscous + unit.viscous * r.backward,
            )
            for r in laws.regimes
        ),
    )
    return plain._replace(
        inertia=unit.inertia * plain.inertia,
        viscous=viscous,
        coulomb=levels[0],
        breakaway=ratio * levels[0],
        constant=unit.constant * plain.constant,
        backlash=unit.gap * plain.backlash,
        backlash_coulomb=loose,
        backlash_breakaway=BACKLASH_BREAKAWAY_RATIO * loose,
        laws=laws,
    ).checked()


@kernel
def worn_loop(
    own: Vector,
    state: Vector,
    running: CompiledProgram,
    reference: Vector,
    period: float,
    delay: int,
    worn: Vector,
    rows: Vector,
    record: Vector,
) -> int:
    """Run one axis with wear in closed loop, as `run` of engine/closed_loop.py does.

    worn (3,): first sample with wear, factor everywhere, factor beyond EDGE. rows (n, 8):
    disturbances (engine/disturbances_and_faults.py), to which the wear is written. Fills record
    (n, 7); returns a status of engine/status_codes.py.
    """
    p, waiting = own.copy(), np.zeros(delay + 1)
    measured = measure(state[POSITION], own[ENCODER_STEP])
    for k in range(reference.shape[0]):
        factor = worn[1] if k >= worn[0] else 1.0
        if k >= worn[0] and state[POSITION] > EDGE:
            factor *= worn[2]
        rows[k, FRICTION] = factor
        measured = encoder_reading(own, state, measured, rows, k)
        command = control_step(running, reference[k], measured, state[VELOCITY])
        status = advance_sample(
            own, state, p, waiting, k, measured, command, period, record[k], own[:0], rows
        )
        if status != OK:
            return int(status)
    return OK


@functools.cache
def controller(loop: Loop) -> Controller:
    """Return the speed controller of the clutch, or the PID."""
    return load(CONTROLLERS / f"{loop}.yaml", Controller)


def steps(seconds: float = SECONDS) -> Vector:
    """Return the reference of 6.3.2: steps of HOLD [s] between 0 and 30 rad, then 20 and 50 rad."""
    period = clutch().bench.sample_period_s
    held = np.arange(round(seconds / period)) // round(HOLD / period)
    forth = held % 2 == 0
    return np.where(
        held < round(seconds / HOLD) // 2, np.where(forth, 30.0, 0.0), np.where(forth, 50.0, 20.0)
    )


def targets(seed: int, seconds: float = SECONDS) -> Vector:
    """Return steps of HOLD [s] to random positions of the travel, at least 8 rad apart."""
    period, draw = (
        clutch().bench.sample_period_s,
        np.random.Generator(np.random.PCG64([seed, TARGETS_STREAM])),
    )
    places: list[float] = []
    last = 0.0
    while len(places) < round(seconds / HOLD):
        place = float(draw.uniform(1.0, 60.0))
        if abs(place - last) >= 8.0:
            places.append(place)
            last = place
    return np.repeat(places, round(HOLD / period))


def run(
    unit: Unit, reference: Vector, seed: int, loop: Loop = "speed", noise: float = NOISE
) -> Run:
    """Return the log of a unit along `reference` (n,) [rad], from rest at 0.

    noise: standard deviation of the measured current [A]; `seed` determines the noise.
    """
    return runs([unit], [reference], [seed], loop, noise)[0]


def runs(
    units: Sequence[Unit],
    references: Sequence[Vector],
    seeds: Sequence[int],
    loop: Loop = "speed",
    noise: float = NOISE,
) -> list[Run]:
    """Return `run` for many units; raise RuntimeError if one cannot be simulated."""
    document, running = controller(loop), compile_program(controller_program(controller(loop)))
    return [
        _one(*each, document, running, noise) for each in zip(units, references, seeds, strict=True)
    ]


def _one(
    unit: Unit,
    reference: Vector,
    seed: int,
    document: Controller,
    running: CompiledProgram,
    noise: float,
) -> Run:
    bench, period, record = (
        clutch().bench,
        document.sample_period_s,
        np.empty((reference.size, RECORD_SIZE)),
    )
    worn, rows = (
        np.array([round(unit.since / period), unit.wear, unit.zone]),
        neutral(reference.size),
    )
    own, state, started = axis(unit).as_array(), rest(), copy_program(running)
    start_at(started, measure(state[POSITION], own[ENCODER_STEP]))
    status = worn_loop(
        own,
        state,
        started,
        reference,
        period,
        document.delay_samples,
        worn,
        rows,
        record,
    )
    if status != OK:
        raise RuntimeError(f"{unit}: status {status}")
    drive: Vector = np.concatenate(
        [np.zeros(unit.late), record[: reference.size - unit.late, TRUE_DRIVE]]
    )
    drive += noise * np.random.Generator(np.random.PCG64([seed, NOISE_STREAM])).standard_normal(
        drive.size
    )
    effort: Vector = bench.actuator.constant.value * drive
    position, velocity = record[:, MEASURED].copy(), record[:, TRUE_VELOCITY].copy()
    time = period * np.arange(reference.size, dtype=np.float64)
    return Run(
        unit, (MotionBlock(time, position, effort, follows=False, velocity=velocity),), velocity
    )


def main(arguments: list[str]) -> int:
    if len(arguments) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    for name, path in zip(("speed", "linear"), arguments, strict=True):
        found = load(Path(path), Controller)
        bare = msgspec.structs.replace(found, certificate=None, weights=found.judged_by)
        (CONTROLLERS / f"{name}.yaml").write_text(to_yaml(bare))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

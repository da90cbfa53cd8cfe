"""Runs of many clutches, each its own plant and wear, as the logs of a fleet would show them;
quick, by the engine alone.

    Unit ──axis──▶ engine/closed_loop.py, sample by sample ──encoder, current with noise──▶ Piece

The plant is configs/clutch/nonlinear.yaml, the second test of thesis 6.3.2: encoder of 56 points,
backlash, viscous friction beyond 260 rad/s (4.4.2.2). What estimates it believes `believed()`, the
same with the inertia 20 % low. The controllers in controllers/ are designs/speed.yaml and
laws/linear.yaml (a PID) of configs/clutch, synthesised for nonlinear.yaml, without their
certificates:

    python -m studies.rigs.clutch_fleet SPEED LINEAR      writes them again, from what `frictool
                                                          synth`
                                                    has made of the two designs
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
from frictool.observe.interval_estimate import Kind
from frictool.observe.motion_block import MotionBlock
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
UNSURE = 0.8  # the inertia that is believed, over the true one (6.3.2)
NOISE = 0.5  # A, standard deviation
SECONDS, HOLD = 20.0, 0.5
EDGE = 30.0  # rad: zone-wise wear is beyond it
UNITS_STREAM, NOISE_STREAM, TARGETS_STREAM = 101, 102, 103  # beside the seed


@dataclass(frozen=True)
class Unit:
    """Factors of one clutch on the parameters of nonlinear.yaml, and its wear.

    wear: of all dry friction, that in the gap too. added [N m]: on top of it, in either direction,
    outside the gap. forward, backward: of one direction, outside the gap. zone: of all dry friction
    beyond EDGE, where the motor is at a sample's beginning. `wear` and `zone` begin at `since` [s],
    the others are there from the start. late: samples by which the logged current is late.
    plain_viscous [N m s/rad]: at every speed. counts: of the encoder a turn, in place of the
    bench's.
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
        """Return the kind of its wear, if the wear is of one kind."""
        if self.added != 0.0:
            return "additive"
        if self.forward != self.backward:
            return "directional"
        if self.zone != 1.0:
            return "zones"
        return "none" if self.wear == 1.0 else "multiplicative"


@dataclass(frozen=True)
class Run:
    """A unit's log in pieces, and what only the simulation knows: velocity (n,) [rad/s] at each
    sample."""

    unit: Unit
    pieces: tuple[MotionBlock, ...]
    velocity: Vector


@functools.cache
def clutch() -> Model:
    """The plant's own model."""
    return load(ROOT / CLUTCH, Model)


@functools.cache
def believed() -> Model:
    """Return the model that an estimator gets: the inertia 20 % low, its range wider by the same
    amount."""
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
    """The model with an encoder of so many counts a turn; as it is for None."""
    if counts is None:
        return model
    encoder = msgspec.structs.replace(model.bench.encoder, counts_per_revolution=counts)
    return msgspec.structs.replace(
        model, bench=msgspec.structs.replace(model.bench, encoder=encoder)
    )


def spread(seed: int, **fields: Any) -> Unit:
    """A unit of the spread of numbers.md 9: viscous +-50 %, friction in the gap +-40 %, its width
    and the inertia +-20 %."""
    draw = np.random.Generator(np.random.PCG64([seed, UNITS_STREAM])).uniform(-1.0, 1.0, 4)
    viscous, gap_friction, gap, inertia = (
        float(1.0 + width * part) for width, part in zip((0.5, 0.4, 0.2, 0.2), draw, strict=True)
    )
    return replace(
        Unit(viscous=viscous, gap_friction=gap_friction, gap=gap, inertia=inertia), **fields
    )


def axis(unit: Unit) -> AxisParameters:
    """The axis of a unit, but for `wear` and `zone`, which the loop below lets come."""
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
    """engine/closed_loop.py `run` of one axis that wears.

    worn (3,): the sample from which it has worn, the factor everywhere, and that beyond EDGE. rows
    (n, 8): engine/disturbances_and_faults.py, filled in with that. Fills record (n, 7), returns
    engine/status_codes.py.
    """
    p, waiting = own.copy(), np.zeros(delay + 1)
    measured = measure(state[POSITION], own[ENCODER_STEP])
    start_at(running, measured)
    for k in range(reference.shape[0]):
        factor = worn[1] if k >= worn[0] else 1.0
        if k >= worn[0] and state[POSITION] > EDGE:
            factor *= worn[2]
        rows[k, FRICTION] = factor
        measured = encoder_reading(own, state, measured, rows, k)
        command = control_step(running, reference[k], measured, state[VELOCITY])
        status = advance_sample(
            own, state, p, waiting, k, measured, command, period, record[k], rows
        )
        if status != OK:
            return int(status)
    return OK


@functools.cache
def controller(loop: Loop) -> Controller:
    """The speed form, or the PID."""
    return load(CONTROLLERS / f"{loop}.yaml", Controller)


def steps(seconds: float = SECONDS) -> Vector:
    """6.3.2: steps between 0 and 30 rad, from the middle on between 20 and 50 rad, held for HOLD
    [s] each."""
    period = clutch().bench.sample_period_s
    held = np.arange(round(seconds / period)) // round(HOLD / period)
    forth = held % 2 == 0
    return np.where(
        held < round(seconds / HOLD) // 2, np.where(forth, 30.0, 0.0), np.where(forth, 50.0, 20.0)
    )


def targets(seed: int, seconds: float = SECONDS) -> Vector:
    """Steps to random places of the travel, 8 rad away at least, held for HOLD [s] each."""
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
    """A unit's log along `reference` (n,) [rad] from rest at 0, the current's noise [A] drawn from
    `seed`."""
    return runs([unit], [reference], [seed], loop, noise)[0]


def runs(
    units: Sequence[Unit],
    references: Sequence[Vector],
    seeds: Sequence[int],
    loop: Loop = "speed",
    noise: float = NOISE,
) -> list[Run]:
    """The same of many. Raises RuntimeError where one cannot be simulated."""
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
    status = worn_loop(
        axis(unit).as_array(),
        rest(),
        copy_program(running),
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

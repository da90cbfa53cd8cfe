"""Simulation of a bench that plays the test signals of `frictool excite`; the result is a log.

A test is either a reference for the bench's position loop (engine/bench_position_loop.py), or a
sequence of drive ramps. A ramp test contains rules for the end of a ramp and for the reversal of
the direction (thesis, figure 4.6). The log has the channels of a bench. The logged position is the
encoder's reading; the drive is measured with noise. The encoder's zero has a random offset of less
than one count. This offset and the noise are drawn from the random generator PCG64 with the seed
`seed`.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
import scipy
from numpy.typing import NDArray

from frictool.adapters.axis_model import load_of
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import CHANNEL_DIMENSIONS, si_unit
from frictool.engine.bench_experiment import play_ramps, play_reference
from frictool.engine.bench_position_loop import PositionServo
from frictool.engine.status_codes import MESSAGES, OK
from frictool.errors import LogError, NoSolutionError
from frictool.logs.canonical.mcap_format import read_mcap
from frictool.logs.canonical.mcap_reader import is_canonical
from frictool.logs.log import EXCITATION, MAIN_TOPIC, Log, Stream
from frictool.logs.provenance import with_provenance
from frictool.simulate.axis_variants import nominal_variant
from frictool.simulate.rig import Rig, rig_of
from frictool.typing import IntVector, Vector

SAME_PERIOD = 1e-6  # relative tolerance of the sample period


class RampRows(NamedTuple):
    """Arguments of `play_ramps` (engine/bench_experiment.py) that describe drive ramps."""

    rows: Vector
    segment: Vector
    following: IntVector
    turning: IntVector
    rules: Vector


def read_excitation(path: Path) -> Log:
    """Read test signals from `path`; raise LogError if `frictool excite` did not write them."""
    log = read_mcap(path) if is_canonical(path) else None
    if log is None or EXCITATION not in log.metadata:
        raise LogError(
            str(path),
            ("is not a test of frictool excite; write one with frictool excite -o NAME.mcap"),
        )
    return log


def is_ramps(excitation: Log) -> bool:
    """Return True if a test consists of drive ramps, False if the test is a position reference."""
    return "reference" not in excitation.main.signals


class BenchPlant(Protocol):
    """Interface of a plant on which a bench can play test signals.

    `follow` and `ramp` simulate a test, write the measured values into `position` and `drive` (n,),
    and return a status of engine/status_codes.py.
    """

    @property
    def name(self) -> str:
        """Return the name of the plant's document."""

    @property
    def rig(self) -> Rig:
        """Return drive, encoder, timing and travel."""

    def follow(
        self, start: float, servo: Vector, reference: Vector, position: Vector, drive: Vector
    ) -> int:
        """Simulate the position loop `servo` with a reference (n,), from rest at `start`.

        `start` and `reference` are in rad | m. The measured values are written into `position` and
        `drive`.
        """

    def ramp(
        self, start: float, ramps: RampRows, position: Vector, drive: Vector, played: IntVector
    ) -> int:
        """Simulate the drive ramps of a test, from rest at `start` [rad | m].

        `played` (1,) receives the number of samples that were simulated.
        """


class AxisBenchPlant:
    """Model of one axis that implements `BenchPlant`."""

    def __init__(self, model: Model) -> None:
        self.name = model.name
        self.rig = rig_of(model.bench)
        self._variant = nominal_variant(model)
        self._load = load_of(model).as_array()

    def follow(
        self, start: float, servo: Vector, reference: Vector, position: Vector, drive: Vector
    ) -> int:
        timing = self.rig.sample_period_s, self.rig.delay_samples
        return int(
            play_reference(
                self._variant.array,
                self._load,
                self._variant.rest(start),
                servo,
                reference,
                *timing,
                position,
                drive,
            )
        )

    def ramp(
        self, start: float, ramps: RampRows, position: Vector, drive: Vector, played: IntVector
    ) -> int:
        timing = self.rig.sample_period_s, self.rig.delay_samples
        return int(
            play_ramps(
                self._variant.array,
                self._load,
                self._variant.rest(start),
                *ramps,
                *timing,
                position,
                drive,
                played,
            )
        )


def bench_test(
    plant: Model | BenchPlant,
    excitation: Log,
    servo: PositionServo,
    noise: float,
    seed: int,
    provenance: Provenance,
    forward: Vector | None = None,
) -> Log:
    """Simulate the test `excitation`; return a log with the position, the drive and the effort.

    If the test has a reference, the log also contains this reference. `servo` is the bench's
    position loop. `noise` is the standard deviation of the noise of the measured drive [A | V].
    `forward` (n,) is a feedforward effort [N m | N], which is added to the effort of the position
    loop. Raises LogError if the test does not belong to the bench of this plant, NoSolutionError if
    the test cannot be simulated.
    """
    bench = AxisBenchPlant(plant) if isinstance(plant, Model) else plant
    rig = bench.rig
    stream = excitation.main
    ramps = is_ramps(excitation)
    played = rig.drive if ramps else "reference"
    if played not in stream.signals:
        raise LogError(
            excitation.source,
            f"has neither reference nor {rig.drive}; found: {', '.join(stream.signals)}",
        )
    if stream.units[played] != si_unit(CHANNEL_DIMENSIONS[played], rig.axis):
        raise LogError(
            excitation.source,
            f"has {played} in {stream.units[played]!r}, but the axis of the model is {rig.axis}; "
            "write a test for that axis",
        )
    if abs(stream.period / rig.sample_period_s - 1.0) > SAME_PERIOD:
        problem = (
            f"has a period of {stream.period:.6g} s, but sample_period_s of the model's bench is "
            f"{rig.sample_period_s:.6g} s"
        )
        raise LogError(excitation.source, f"{problem}; write a test for that bench")
    generator = np.random.Generator(np.random.PCG64(seed))
    phase = rig.resolution * generator.random()
    position, drive = (
        _ramps(bench, excitation, phase)
        if ramps
        else _reference(bench, excitation, servo, phase, forward)
    )
    drive = drive + noise * generator.standard_normal(drive.size)
    columns = {"position": position, rig.drive: drive, "effort": rig.constant * drive}
    if not ramps:
        columns["reference"] = stream.signals["reference"]
    kinds = {"effort": rig.effort_axis}
    units = {name: si_unit(CHANNEL_DIMENSIONS[name], kinds.get(name, rig.axis)) for name in columns}
    logged = Stream(MAIN_TOPIC, stream.time[: position.size], columns, units)
    kind = excitation.metadata[EXCITATION].get("kind", "")
    about = {"log": {"kind": "simulated", "test": kind, "model": bench.name}}
    return with_provenance(Log((logged,), about, kind, tuple(_at_stops(rig, position))), provenance)


def _at_stops(rig: Rig, position: Vector) -> list[str]:
    travel, step = rig.travel, rig.resolution
    if travel is None:
        return []
    near = (
        (travel.low, position.min() < travel.low + step),
        (travel.high, position.max() > travel.high - step),
    )
    return [
        f"the axis comes within one encoder count of the end stop at {end:g} {travel.unit}; "
        "choose a test with a smaller range of positions"
        for end, hit in near
        if hit
    ]


def _reference(
    bench: BenchPlant,
    excitation: Log,
    servo: PositionServo,
    phase: float,
    forward: Vector | None,
) -> tuple[Vector, Vector]:
    reference = excitation.main.signals["reference"]
    _within_travel(bench.rig, excitation, reference)
    if forward is not None:
        reference = _with_feedforward(reference, forward, servo, bench.rig.sample_period_s)
    position, drive = np.empty(reference.size), np.empty(reference.size)
    _check(
        excitation,
        bench.follow(float(reference[0]) + phase, np.array(servo), reference, position, drive),
    )
    return position, drive


def _with_feedforward(
    reference: Vector, forward: Vector, servo: PositionServo, period: float
) -> Vector:
    """Return the reference (n,) with which the servo's effort increases by `forward` (n,).

    The change d of the reference solves P d[k] + w D (d[k] - d[k-1])/period = forward[k]. P and D
    are gains of the servo, and w is the weight of the reference in the derivative term.
    """
    rate = servo.reference_rate * servo.derivative / period
    added = scipy.signal.lfilter([1.0], [servo.proportional + rate, -rate], forward)
    return np.asarray(reference + added)


def _ramps(bench: BenchPlant, excitation: Log, phase: float) -> tuple[Vector, Vector]:
    about = excitation.metadata[EXCITATION]
    signals = excitation.main.signals
    rows = signals[bench.rig.drive]
    segment = signals["segment"]
    low, high = (
        float(about.get(name, side)) for name, side in (("turn_low", "-inf"), ("turn_high", "inf"))
    )
    rules = np.array([float(about.get("advance_on", "inf")), low, high])
    position = np.empty(rows.size)
    drive = np.empty(rows.size)
    played = np.zeros(1, dtype=np.int64)
    ramps = RampRows(rows, segment, _next_change(segment), _next_change(np.sign(segment)), rules)
    _check(
        excitation,
        bench.ramp((low if math.isfinite(low) else 0.0) + phase, ramps, position, drive, played),
    )
    return position[: played[0]], drive[: played[0]]


def _next_change(values: Vector) -> NDArray[np.int64]:
    edges = np.append(np.flatnonzero(np.diff(values)) + 1, values.size)
    return edges[np.searchsorted(edges, np.arange(values.size), side="right")]


def _within_travel(rig: Rig, excitation: Log, reference: Vector) -> None:
    travel = rig.travel
    if travel is not None and not travel.low <= reference.min() <= reference.max() <= travel.high:
        path = f"has a reference from {reference.min():.4g} to {reference.max():.4g} {travel.unit}"
        raise LogError(
            excitation.source,
            f"{path}; allowed: the travel of the model's bench, {travel.low:g} to {travel.high:g}",
        )


def _check(excitation: Log, status: int) -> None:
    if status != OK:
        raise NoSolutionError(
            f"{excitation.source}: {MESSAGES[status]}; check the model's parameters and the gains"
        )

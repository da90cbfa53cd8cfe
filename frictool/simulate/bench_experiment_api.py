"""Python function that plays a test of `frictool.identify.excite` on a simulated bench."""

from __future__ import annotations

from frictool.documents.model import Model
from frictool.documents.provenance import Provenance, provenance_of_call
from frictool.engine.bench_position_loop import PositionServo
from frictool.errors import LogError
from frictool.logs.log import Log
from frictool.simulate.bench_experiment import bench_test, is_ramps
from frictool.typing import Vector

AT_REST = PositionServo(0.0, 0.0, 0.0, 0.0)


def play(
    model: Model,
    test: Log,
    *,
    servo: PositionServo | None = None,
    drive_noise: float = 0.0,
    seed: int = 0,
    provenance: Provenance | None = None,
    forward: Vector | None = None,
) -> Log:
    """Simulate how the bench of a model plays test signals.

    The test is a sequence of drive ramps, or a reference for the position loop `servo`.

    Parameters
    ----------
    model : Model
        Model of the axis.
    test : Log
        Test sequence (`Sequence.as_log`).
    servo : PositionServo, optional
        Position loop of the bench, from position to effort; required for a reference.
    drive_noise : float
        Standard deviation of the noise of the measured drive [A | V].
    seed : int
        Seed of the noise and of the encoder's zero.
    provenance : Provenance, optional
        Origin that the log states; by default, the call of this function.
    forward : Vector, optional
        Feedforward (n,) [N m | N] that is added to the effort of the bench's position loop.

    Returns
    -------
    Log
        Log of the bench.

    Raises
    ------
    LogError
        If the test does not belong to this bench.
    NoSolutionError
        If the test cannot be simulated.
    """
    if servo is None and not is_ramps(test):
        raise LogError(
            test.source,
            "is a test with a reference; give `servo`, the gains of the bench's position loop",
        )
    origin = provenance or provenance_of_call("frictool.simulate.play", model=model)
    return bench_test(model, test, servo or AT_REST, drive_noise, seed, origin, forward)

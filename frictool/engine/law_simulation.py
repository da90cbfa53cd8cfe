"""Simulation of a mass with any law of friction/law_registry.py under a sequence of efforts.

    static    without a rest band    event-driven engine with error control
              with a rest band       the thesis's equations with a fixed time step
    dynamic                          Rosenbrock method with error control
    hybrid                           the thesis's equations with a fixed time step

A rest band is a range of low velocities that a law treats as rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from frictool.engine.body import EVENT_SIZE, SAMPLE_SIZE, FrictionBody
from frictool.engine.drive import EffortFunction
from frictool.engine.dynamic_law_motion import law_kernels, run_dynamic, virgin_contact
from frictool.engine.fixed_step_laws import run_band, run_hybrid
from frictool.engine.rosenbrock import CONTACT
from frictool.engine.status_codes import OK
from frictool.engine.stick_slip_run import MOST_EVENTS, Trajectory, segment_arrays, simulate
from frictool.friction import kernel_signatures as s
from frictool.friction.law import DynamicKernels, HybridKernels, Law, StaticKernels
from frictool.friction.law_extension import FrictionExtension, pack_plain_law
from frictool.runtime.kernels import function_pointer
from frictool.typing import Vector

Segments = Sequence[tuple[float, EffortFunction]]

STEP_TOLERANCE = 1e-7  # relative tolerance of the dynamic laws


def body_of(
    law: Law, p: Vector, mass: float, extension: FrictionExtension | None = None
) -> FrictionBody:
    """Return a body with a static friction law, for the event-driven engine.

    p: parameter array, `law.pack(...)`. Fields of the body that do not depend on the law have their
    default values. Raises ValueError if the law is not static, treats low velocities as rest, or
    does not support the extension.
    """
    kernels = law.kernels
    if not isinstance(kernels, StaticKernels) or kernels.band(p) > 0.0:
        raise ValueError(
            f"found law {law.name}; allowed: static laws that stick exactly; "
            "run_law simulates any law"
        )
    straight, scale = law.slip_scales(p)
    packed = extension.pack(law, p) if extension is not None and not extension.plain else None
    back = p if packed is None else packed.backward
    names = [parameter.name for parameter in law.parameters]
    viscous = names.index("viscous") if "viscous" in names else None
    return FrictionBody(
        mass,
        kernels.slip_force,
        p,
        breakaway=(float(kernels.breakaway(-1.0, back)), float(kernels.breakaway(1.0, p))),
        coulomb=(float(back[0]), float(p[0])),
        viscous=(0.0, 0.0) if viscous is None else (float(back[viscous]), float(p[viscous])),
        straight_from=straight,
        speed_scale=scale,
        extension=packed,
    )


def _pointers(parts: Sequence[Any], types: Sequence[Any]) -> Any:
    return tuple(function_pointer(part, kind) for part, kind in zip(parts, types, strict=True))


@dataclass(frozen=True)
class LawRunSettings:
    """Settings of a simulation of one law.

    step: time step [s], required and used only by a law with a fixed step.
    tolerance: relative tolerance of a dynamic law.
    speed_scale: reference speed of the error control [m/s | rad/s]; the error of a lower speed is
        measured relative to `speed_scale`.
    length_scale: presliding displacement [m | rad]; the error of an internal state is measured
        relative to the change of the state over this displacement.
    extension: extended friction (friction/law_extension.py); a body at rest begins its rest at 0 s.
    most_events: allowed number of events.
    """

    step: float | None = None
    tolerance: float = STEP_TOLERANCE
    speed_scale: float = 1e-3
    length_scale: float = 1e-5
    extension: FrictionExtension | None = None
    most_events: int = MOST_EVENTS


def run_law(
    law: Law,
    p: Vector,
    mass: float,
    segments: Segments,
    times: ArrayLike,
    settings: LawRunSettings | None = None,
) -> Trajectory:
    """Simulate a mass with a friction law under a sequence of efforts, from rest at position 0.

    Parameters
    ----------
    law, p
        The law and its parameters, `law.pack(...)`.
    mass
        Mass [kg | kg m2]. The parameters of a hybrid law contain the same mass.
    segments
        Pairs (end [s], drive) in order of time.
    times
        Ascending times [s] of the samples, within the run.
    settings
        By default LawRunSettings().

    Returns
    -------
    Trajectory
        Samples, events and final state.

    Raises
    ------
    ValueError
        If segments, times or step are invalid, or the law does not support `settings.extension`.
    """
    settings = settings or LawRunSettings()
    extension, step = settings.extension, settings.step
    ends, drives, sample_times = segment_arrays(segments, times, 0.0)
    kernels = law.kernels
    p = np.array(p, dtype=np.float64)
    if isinstance(kernels, StaticKernels) and kernels.band(p) == 0.0:
        return simulate(
            body_of(law, p, mass, extension), segments, times, most_events=settings.most_events
        )
    packed = pack_plain_law(p) if extension is None or extension.plain else extension.pack(law, p)
    laws = (*packed, p.copy())
    samples = np.full((sample_times.size, SAMPLE_SIZE), np.nan)
    events = np.zeros((settings.most_events, EVENT_SIZE))
    if isinstance(kernels, DynamicKernels):
        scales = np.array([settings.tolerance, settings.speed_scale, 0.0, settings.length_scale])
        return _run_dynamic(kernels, laws, mass, (ends, drives), sample_times, samples, scales)
    if step is None or not 0.0 < step <= ends[-1]:
        raise ValueError(
            f"{law.name}: step: found {step}; allowed: above 0 s, and at most the duration of "
            f"the run, {ends[-1]:g} s"
        )
    state = np.zeros(3)
    if isinstance(kernels, HybridKernels):
        types = (
            s.MODE_AFTER,
            s.ENTER,
            s.HYBRID_FORCE,
            s.HYBRID_ACCELERATION,
            s.HYBRID_RATE,
            s.HYBRID_COMMIT,
        )
        driver: Any = run_hybrid
        parts = _pointers(kernels[:6], types)
        past = np.zeros(1 + (0 if extension is None else round(extension.delay / step)))
        outcome = driver(
            *parts,
            laws,
            kernels.reset(p),
            past,
            state,
            0.0,
            step,
            ends,
            drives,
            sample_times,
            samples,
            events,
        )
    else:
        chosen = (kernels.slip_force, kernels.breakaway, kernels.band, kernels.seen_velocity)
        driver = run_band
        parts = _pointers(chosen, (s.SLIP_FORCE, s.BREAKAWAY, s.BAND, s.SEEN_VELOCITY))
        outcome = driver(
            *parts, laws, mass, state, 0.0, step, ends, drives, sample_times, samples, events
        )
    status, reached, happened = outcome
    return Trajectory(status, reached, sample_times, samples, events[:happened].copy(), state)


def _run_dynamic(
    kernels: DynamicKernels,
    laws: Any,
    mass: float,
    segments: tuple[Vector, Vector],
    times: Vector,
    samples: Vector,
    scales: Vector,
) -> Trajectory:
    z, moving, sizes = virgin_contact(kernels, laws[3], scales[1], scales[CONTACT])
    y = np.concatenate([np.zeros(CONTACT), z])
    scales = np.concatenate([scales[:CONTACT], sizes])
    status, reached = run_dynamic(
        law_kernels(kernels), laws, mass, y, moving, scales, 0.0, *segments, times, samples
    )
    if status != OK:
        samples[times > reached] = np.nan
    return Trajectory(status, reached, times, samples, np.zeros((0, EVENT_SIZE)), y)

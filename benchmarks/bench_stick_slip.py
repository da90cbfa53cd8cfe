"""Stick-slip test (3.7.2, table 3.1) of 60 s: the engine against other integrators.

Further rows are the same test with extended friction, and 1000 steps of the clutch. Errors are the
largest errors of nine breakaway times, against DOP853 with a relative tolerance of 1e-12. Nothing
is integrated while the mass sticks; each peer that detects the stop also skips this time. Before
the timing, the engine's parameters are packed, and diffrax's function is compiled.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numba
import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from benchmarks.bench_simulate import CLUTCH, PERIOD, START, USUAL, closed_loop, replay
from benchmarks.timing import pair
from frictool.adapters.controller_composition import controller_program
from frictool.control.compiled_program import compile_program
from frictool.engine.body import BREAKS_AWAY, STATE_SIZE
from frictool.engine.closed_loop import COMMAND
from frictool.engine.drive import spring
from frictool.engine.extended_friction_motion import EXTENDED_SIZE
from frictool.engine.law_simulation import body_of
from frictool.engine.parallel_runs import replay_axes
from frictool.engine.stick_slip import run, run_extended
from frictool.friction.kernel_signatures import SLIP_FORCE
from frictool.friction.law_extension import FrictionExtension
from frictool.friction.law_registry import LAWS
from frictool.plant.axis import rest
from frictool.runtime.kernels import function_pointer, kernel
from frictool.typing import Vector
from studies.references.event_integration import TIGHT
from studies.references.extended_friction import Slow
from studies.references.stick_slip import reference_breakaways
from studies.rigs.example_controllers import clutch_controller

MASS, COULOMB, BREAKAWAY, STRIBECK, VISCOUS = 1.0, 1.0, 1.5, 1e-3, 0.4
STIFFNESS, SPEED, SECONDS, SLIPS = 2.0, 0.1, 60.0, 9
RTOL, ATOL, FIXED_STEP = 1e-8, 1e-11, 1e-5
MUJOCO_STEP = 1e-4
ROUNDS, PLANTS = 5, 1000
LEAST_SECONDS = 0.02  # of a round: both sides then meet the same machine

LAW = LAWS["stribeck"]
P = LAW.pack(
    {"coulomb": COULOMB, "breakaway": BREAKAWAY, "stribeck_velocity": STRIBECK, "viscous": VISCOUS}
)
TOLERANCE = 1.5e-6  # for the peers' accuracy, not more
BODY, DRIVE = replace(body_of(LAW, P, MASS), tolerance=TOLERANCE), spring(STIFFNESS, SPEED)

FACTOR, FRESH, RISE_TIME, MEMORY = (1.0, 0.02), 0.8, 0.5, 2e-3
EXTENSION = FrictionExtension(
    forward=FACTOR,
    backward=FACTOR,
    travel=(0.0, 10.0),
    fresh=FRESH,
    rise_time=RISE_TIME,
    lag=MEMORY,
)
EXTENDED = replace(
    body_of(LAW, P, MASS, EXTENSION), tolerance=1e-9
)  # the peer is as accurate here: the film's lag keeps steps short


def prepared() -> Callable[[], Vector]:
    """Return a function that runs the engine and returns the breakaway times."""
    force, body = function_pointer(LAW.kernels.slip_force, SLIP_FORCE), BODY.as_array()
    ends, drives = np.array([SECONDS]), DRIVE.as_array()[None]
    none, nothing, events = np.empty(0), np.empty((0, 5)), np.empty((200, 4))

    @numba.njit
    def compiled(
        p: Vector,
        body: Vector,
        ends: Vector,
        drives: Vector,
        none: Vector,
        nothing: Vector,
        events: Vector,
    ) -> Any:
        return run(force, p, body, np.zeros(STATE_SIZE), 0.0, ends, drives, none, nothing, events)

    def once() -> Vector:
        _, _, happened = compiled(P, body, ends, drives, none, nothing, events)
        return events[:happened][events[:happened, 1] == BREAKS_AWAY, 0]

    return once


def prepared_extended() -> Callable[[], Vector]:
    """Return the same function as `prepared`, for a body with extended friction."""
    force, packed, body = (
        function_pointer(LAW.kernels.slip_force, SLIP_FORCE),
        EXTENSION.pack(LAW, P),
        EXTENDED.as_array(),
    )
    ends, drives = np.array([SECONDS]), DRIVE.as_array()[None]
    none, nothing, events = np.empty(0), np.empty((0, 5)), np.empty((200, 4))

    def once() -> Vector:
        _, _, happened = run_extended(
            force, *packed, body, np.zeros(EXTENDED_SIZE), 0.0, ends, drives, none, nothing, events
        )
        return events[:happened][events[:happened, 1] == BREAKS_AWAY, 0]

    return once


def friction(v: float) -> float:
    return COULOMB + (BREAKAWAY - COULOMB) * math.exp(-((v / STRIBECK) ** 2)) + VISCOUS * v


def next_breakaway(x: float) -> float:
    """Return the time when the spring reaches the breakaway force, with the mass at rest at x."""
    return (x + BREAKAWAY / STIFFNESS) / SPEED


def with_solve_ivp() -> Vector:
    """Return the breakaway times by RK45, which integrates each slip until the stop (event)."""

    def field(t: float, y: Vector) -> list[float]:
        return [y[1], (STIFFNESS * (SPEED * t - y[0]) - friction(y[1])) / MASS]

    def stop(_: float, y: Vector) -> float:
        return float(y[1])

    stop.terminal, stop.direction = True, -1
    times, t, x = [], next_breakaway(0.0), 0.0
    while t < SECONDS:
        times.append(t)
        slip = solve_ivp(field, (t, SECONDS), [x, 0.0], events=stop, rtol=RTOL, atol=ATOL)
        if not slip.t_events[0].size:
            break
        x = float(slip.y[0, -1])
        t = next_breakaway(x)
    return np.array(times)


def extended_with_solve_ivp() -> Vector:
    """Return the breakaway times of the extended friction by RK45.

    In slip, RK45 integrates position, velocity and the velocity w of the lubricant film. At rest, w
    decays, and a root finder computes the breakaway.
    """
    t, x, w, times = 0.0, 0.0, 0.0, []

    def dry(x: float, w: float, rested: float) -> float:
        fallen = math.exp(-((w / STRIBECK) ** 2))
        grown = 1.0 - (1.0 - FRESH) * RISE_TIME / (RISE_TIME + rested)
        return (FACTOR[0] + FACTOR[1] * x) * (COULOMB + (BREAKAWAY * grown - COULOMB) * fallen)

    def missing(rested: float) -> float:
        return dry(x, w * math.exp(-rested / MEMORY), rested) - STIFFNESS * (
            SPEED * (t + rested) - x
        )

    while t < SECONDS:
        rested = brentq(missing, 0.0, 2.0 * SECONDS, xtol=1e-12) if missing(0.0) > 0.0 else 0.0
        t, w = t + rested, w * math.exp(-rested / MEMORY)
        if t >= SECONDS:
            break
        times.append(t)

        def field(t: float, y: Vector, rested: float = rested) -> list[float]:
            friction = dry(y[0], y[2], rested) + VISCOUS * y[1]
            return [
                y[1],
                (STIFFNESS * (SPEED * t - y[0]) - friction) / MASS,
                (y[1] - y[2]) / MEMORY,
            ]

        def stop(_: float, y: Vector) -> float:
            return float(y[1])

        stop.terminal, stop.direction = True, -1
        run = solve_ivp(field, (t, SECONDS), [x, 0.0, w], events=stop, rtol=RTOL, atol=ATOL)
        t, x, w = float(run.t[-1]), float(run.y[0, -1]), float(run.y[2, -1])
    return np.array(times)


@kernel
def fixed_steps(step: float, times: Vector) -> int:
    """Simulate by semi-implicit Euler with a stick mode; return the number of breakaways."""
    x, v, stuck, found = 0.0, 0.0, True, 0
    for k in range(round(SECONDS / step)):
        u = STIFFNESS * (SPEED * k * step - x)
        if stuck and u > BREAKAWAY and found < times.shape[0]:
            stuck, times[found] = False, k * step
            found += 1
        if not stuck:
            v += (
                step
                * (
                    u
                    - (
                        COULOMB
                        + (BREAKAWAY - COULOMB) * math.exp(-((v / STRIBECK) ** 2))
                        + VISCOUS * v
                    )
                )
                / MASS
            )
            if v <= 0.0 and u < BREAKAWAY:
                v, stuck = 0.0, True
            x += step * v
    return found


def with_fixed_step() -> Vector:
    times = np.empty(100)
    return times[: fixed_steps(FIXED_STEP, times)]


def with_diffrax() -> Callable[[], Vector]:
    """Return a function that computes the breakaway times by diffrax's Dopri5.

    The stop is an event, the duration of a stick has a closed form, and all slips are one compiled
    scan.
    """
    import diffrax
    import jax
    import jax.numpy as jnp
    import optimistix

    jax.config.update("jax_enable_x64", True)

    def field(t: Any, y: Any, _: Any) -> Any:
        g = COULOMB + (BREAKAWAY - COULOMB) * jnp.exp(-((y[1] / STRIBECK) ** 2)) + VISCOUS * y[1]
        return jnp.stack([y[1], (STIFFNESS * (SPEED * t - y[0]) - g) / MASS])

    def falling(t: Any, y: Any, *_: Any, **__: Any) -> Any:
        return y[1] + jnp.where(
            STIFFNESS * (SPEED * t - y[0]) > COULOMB, 1e-9, 0.0
        )  # not at the start, where v = 0 too

    event = diffrax.Event(falling, root_finder=optimistix.Newton(RTOL, ATOL))
    control = diffrax.PIDController(rtol=RTOL, atol=ATOL)

    def slip(x: Any, _: Any) -> Any:
        t = (x + BREAKAWAY / STIFFNESS) / SPEED
        end = diffrax.diffeqsolve(
            diffrax.ODETerm(field), diffrax.Dopri5(), t, t + 20.0, 1e-4, jnp.stack([x, 0.0 * x]),
            stepsize_controller=control, event=event, max_steps=100_000,
        )  # fmt: skip
        return end.ys[-1, 0], t

    compiled = jax.jit(lambda x: jax.lax.scan(slip, x, None, length=SLIPS)[1])
    start = jnp.asarray(0.0)
    return lambda: np.asarray(compiled(start).block_until_ready())


def with_mujoco() -> Callable[[], Vector]:
    """Return a function that computes the start times of motion by MuJoCo's friction loss.

    MuJoCo has no breakaway above the Coulomb friction.
    """
    import mujoco

    model = mujoco.MjModel.from_xml_string(f"""<mujoco>
      <option timestep="{MUJOCO_STEP}" gravity="0 0 0"/><worldbody><body>
      <joint name="slide" type="slide" axis="1 0 0" damping="{VISCOUS}" frictionloss="{COULOMB}"/>
      <geom size=".1" mass="{MASS}"/>
      </body></worldbody>
      <actuator><position joint="slide" kp="{STIFFNESS}"/></actuator></mujoco>""")
    data = mujoco.MjData(model)

    def once() -> Vector:
        mujoco.mj_resetData(model, data)
        times, moving = [], False
        for k in range(round(SECONDS / MUJOCO_STEP)):
            data.ctrl[0] = SPEED * k * MUJOCO_STEP
            mujoco.mj_step(model, data)
            speed = data.qvel[0]
            if not moving and speed > 10.0 * STRIBECK:
                times.append(k * MUJOCO_STEP)
            moving = speed > (STRIBECK if moving else 10.0 * STRIBECK)
        return np.array(times)

    return once


def error_of(times: Vector, exact: Vector) -> str:
    if times.size != exact.size:
        return f"{times.size} breakaways instead of {exact.size}"
    return f"{np.max(np.abs(times - exact)):.1e} s"


def repeated(call: Callable[[], Any], count: int) -> Callable[[], Any]:
    return lambda: [call() for _ in range(count)]


def timed(call: Callable[[], Any]) -> float:
    """Return the wall time of the second of two calls [s]."""
    call()
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def row(
    name: str, peer: str, theirs: Callable[[], Vector], rounds: int = ROUNDS, extended: bool = False
) -> dict[str, Any]:
    """Return the row of the wall time of 60 s."""
    ours = prepared_extended() if extended else prepared()
    exact = np.array(
        (
            Slow(EXTENSION, DRIVE).breakaways(SECONDS)
            if extended
            else reference_breakaways(BODY, DRIVE, SECONDS)
        )[0]
    )
    counts = [max(1, math.ceil(LEAST_SECONDS / timed(call))) for call in (ours, theirs)]
    many = pair(
        *(repeated(call, n) for call, n in zip((ours, theirs), counts, strict=True)), rounds
    )
    seconds, their_seconds = (taken / n for taken, n in zip(many, counts, strict=True))
    return {
        "id": name,
        "peer": peer,
        "ours": seconds,
        "theirs": their_seconds,
        "unit": "s",
        "ratio": their_seconds / seconds,
        "accuracy": (
            f"breakaway times within {error_of(ours(), exact)}, peer {error_of(theirs(), exact)}; "
            f"{SECONDS / seconds:.2g} times real time, peer {SECONDS / their_seconds:.2g}"
        ),
    }


def stick_slip_solve_ivp() -> dict[str, Any]:
    """Return the row against scipy's RK45 with events."""
    return row("stick_slip.solve_ivp", "scipy solve_ivp", with_solve_ivp)


def stick_slip_fixed_step() -> dict[str, Any]:
    """Return the row against a compiled loop of small steps."""
    return row("stick_slip.fixed_step", f"numba, step {FIXED_STEP:g} s", with_fixed_step)


def stick_slip_diffrax() -> dict[str, Any]:
    """Return the row against compiled diffrax with events."""
    return row("stick_slip.diffrax", "diffrax", with_diffrax())


def stick_slip_mujoco() -> dict[str, Any]:
    """Return the row against MuJoCo's friction loss."""
    return row("stick_slip.mujoco", "mujoco", with_mujoco(), rounds=1)


def stick_slip_extended() -> dict[str, Any]:
    """Return the row of extended friction against scipy's RK45.

    The friction varies with position and lags behind the velocity; the breakaway grows with the
    time at rest.
    """
    return row("stick_slip.extended", "scipy solve_ivp", extended_with_solve_ivp, extended=True)


def clutch_batch_solve_ivp() -> dict[str, Any]:
    """Return the row of 1000 different clutches, moved for 1.1 s under given commands.

    The peer moves two clutches by `solve_ivp`, as in simulate.clutch_step.
    """
    acting = np.concatenate(
        [[0.0], closed_loop(compile_program(controller_program(clutch_controller())))[:-1, COMMAND]]
    )
    factors = np.random.default_rng(6).uniform(0.7, 1.3, (PLANTS, 2))
    plants = [
        CLUTCH._replace(
            coulomb=CLUTCH.coulomb * f, breakaway=CLUTCH.breakaway * f,
            backlash_coulomb=CLUTCH.backlash_coulomb * f,
            backlash_breakaway=CLUTCH.backlash_breakaway * f,
            inertia=CLUTCH.inertia * (1.0 + 0.2 * (j - 1.0)),
        )
        for f, j in [(1.0, 1.0), *factors[1:]]
    ]  # fmt: skip
    axes, commands = np.stack([plant.as_array() for plant in plants]), np.stack([acting] * PLANTS)
    positions, statuses = np.empty(commands.shape), np.zeros(PLANTS, dtype=np.int64)
    ours, theirs = pair(
        lambda: replay_axes(
            axes, np.stack([rest(START)] * PLANTS), commands, PERIOD, positions, statuses
        ),
        lambda: [replay(acting, USUAL) for _ in range(2)],
        ROUNDS,
    )
    assert not np.any(statuses)
    exact, theirs_at = replay(acting, TIGHT), replay(acting, USUAL)
    errors = [float(np.max(np.abs(found - exact))) for found in (positions[0], theirs_at)]
    return {
        "id": "clutch_batch.solve_ivp",
        "peer": "scipy solve_ivp, 2 of them",
        "ours": ours,
        "theirs": theirs,
        "unit": "s",
        "ratio": theirs / ours,
        "accuracy": (
            f"{PLANTS} plants for {acting.size * PERIOD:g} s, {1e6 * ours / PLANTS:.3g} us each "
            f"on {numba.get_num_threads()} threads; "
            f"position within {errors[0]:.1e} rad, peer {errors[1]:.1e} rad"
        ),
    }


ROWS = [
    stick_slip_solve_ivp,
    stick_slip_extended,
    stick_slip_fixed_step,
    stick_slip_diffrax,
    stick_slip_mujoco,
    clutch_batch_solve_ivp,
]
for _row in ROWS:
    _row.id = _row.__name__.replace("_solve_ivp", ".solve_ivp").replace(
        "stick_slip_", "stick_slip."
    )

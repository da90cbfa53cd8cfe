"""Simulation of mechanisms with many blocks.

The engine is compared with real time, with linear growth over the number of blocks, and with other
integrators of the same equations. The mechanism is a row of sliders of 0.1 kg with dry friction
(0.1 N, breakaway 0.13 N, 0.05 N s/m). Springs between neighbours have a damping ratio of 2 %; the
resonances of 20 sliders are between 8 Hz and 100 Hz. Three of the links have a play of 2 mm. The
engine treats friction and flanks exactly, because it computes the time of each stop, breakaway and
contact. Errors are those of the final positions against the engine at a tolerance of 1e-12, divided
by the distance that the driven slider moves.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.timing import pair
from frictool.engine.mechanism.open_loop_run import MechanismRun, run
from frictool.engine.mechanism.preparation import prepare
from frictool.engine.mechanism.state import rest
from frictool.typing import Vector
from studies.rigs.mechanism_builder import Builder

MASS, COULOMB, BREAKAWAY, VISCOUS, HIGHEST, DAMPING, GAP = 0.1, 0.1, 0.13, 0.05, 100.0, 0.02, 1e-3
STIFFNESS = (
    MASS * (np.pi * HIGHEST) ** 2
)  # the highest resonance of a long chain is (1/pi) sqrt(k/m)
DAMPER = 2.0 * DAMPING * np.sqrt(STIFFNESS * MASS)
SECONDS, PERIOD, ROUNDS = 2.0, 1e-3, 5
LENGTHS = (20, 40, 80, 160)
SWITCHES, HELD, PEER_SECONDS = (
    2,
    4.0,
    0.1,
)  # against peers: an effort that changes sign, so that none is stopped by samples
MUJOCO_STEP = 1e-4
STIFFNESSES = (1e5, 1e8, 1e10, 1e12)  # N m/rad
MOST_COST = 10.0  # largest cost of a stiff link, relative to that of the first


def chain(count: int, gaps: int = 3) -> Builder:
    """Return the mechanism with `count` sliders and `gaps` links with play per 20 sliders."""
    b = Builder()
    for i in range(count):
        b.block(MASS, 0.5)
        b.friction(i, "svc", coulomb=COULOMB, breakaway=BREAKAWAY, viscous=VISCOUS)
        if i > 0:
            played = gaps > 0 and i % (20 // gaps) == 0
            b.coupling(i - 1, i, STIFFNESS, DAMPER, gap=GAP if played else 0.0)
    b.source(0)
    return b


def player(
    b: Builder, commands: Vector, period: float, tolerance: float | None = None
) -> Callable[[], MechanismRun]:
    """Return a function that simulates the mechanism from rest."""
    packed = b.packed()
    machine, start = prepare(packed), np.zeros(len(b.inertia))
    more = {} if tolerance is None else {"tolerance": tolerance}
    return lambda: run(machine, rest(packed, machine, start), commands, period, **more)


def swinging(count: int) -> Vector:
    """Return commands (n, 1) [N] that make all sliders stick and slip.

    They are a sine of 1 Hz with three times the Coulomb friction of all sliders together.
    """
    return 0.3 * count * np.sin(2.0 * np.pi * PERIOD * np.arange(round(SECONDS / PERIOD)))[:, None]


def switching() -> Vector:
    return HELD * np.array([1.0, -1.0] * (SWITCHES // 2))[:, None]


def cost(call: Callable[[], Any]) -> float:
    """Return the least processor time of several calls in one thread [s]."""
    call()
    taken = []
    for _ in range(ROUNDS):
        start = time.thread_time()
        call()
        taken.append(time.thread_time() - start)
    return min(taken)


def mechanism_real_time() -> dict[str, Any]:
    """Return the row of 20 sliders with play against real time; a ratio of 100 is required.

    Each command is constant for 1 ms.
    """
    call = player(chain(20), swinging(20), PERIOD)
    ours = cost(call)
    found = call()
    happened = np.unique(found.events[:, 0]).size
    return {
        "peer": "real time",
        "ours": ours,
        "theirs": SECONDS,
        "unit": "s",
        "ratio": SECONDS / ours,
        "accuracy": f"{happened} instants found in {SECONDS:g} s",
    }


def _slope(calls: list[Callable[[], Any]]) -> tuple[float, list[float]]:
    seconds = [cost(call) for call in calls]
    return float(np.polyfit(np.log(LENGTHS), np.log(seconds), 1)[0]), seconds


def mechanism_length() -> dict[str, Any]:
    """Return the row of the growth of the cost over the number of sliders, all of which slip.

    The cost is proportional to a power of this number. The exponent is compared with 1.
    """
    t = PERIOD * np.arange(round(SECONDS / PERIOD))
    calls = []
    for count in LENGTHS:
        commands = count * (0.3 + 0.1 * np.minimum(1.0, t) * np.sin(2.0 * np.pi * t))[:, None]
        calls.append(player(chain(count, 0), commands, PERIOD))
    slope, seconds = _slope(calls)
    events, _ = _slope([player(chain(count), swinging(count), PERIOD) for count in LENGTHS])
    return {
        "peer": "linear growth",
        "ours": slope,
        "theirs": 1.0,
        "unit": "exponent",
        "ratio": 1.0 / slope,
        "accuracy": ", ".join(
            f"{n}: {1e3 * s:.3g} ms" for n, s in zip(LENGTHS, seconds, strict=True)
        )
        + "; where each slider sticks and slips, so that events grow with the length too: "
        f"exponent {events:.2f}",
    }


class Switching:
    """The same chain for `solve_ivp`, with an event for the stop or breakaway of each slider.

    The mode of each slider, stick or slip, is constant between events.
    """

    def __init__(self, count: int) -> None:
        self.count, self.modes, self.effort = count, np.zeros(count), 0.0

    def pull(self, y: Vector) -> Vector:
        """Return the efforts on the sliders (n,) [N] without dry friction."""
        x, v = y[: self.count], y[self.count :]
        force = STIFFNESS * np.diff(x) + DAMPER * np.diff(v)
        total = -VISCOUS * v
        total[:-1] += force
        total[1:] -= force
        total[0] += self.effort
        return np.asarray(total)

    def rates(self, _: float, y: Vector) -> Vector:
        slip = np.where(self.modes == 0.0, 0.0, (self.pull(y) - COULOMB * self.modes) / MASS)
        return np.concatenate([y[self.count :], slip])

    def settle(self, y: Vector, stopped: int | None, started: int | None) -> None:
        """Set the modes after an event in which slider `stopped` stops or `started` breaks away."""
        pull = self.pull(y)
        for i in range(self.count):
            if i == stopped:
                y[self.count + i], self.modes[i] = 0.0, 0.0
            if self.modes[i] == 0.0 and (i == started or abs(pull[i]) >= BREAKAWAY):
                self.modes[i] = np.sign(pull[i])

    def play(self, rtol: float, atol: float) -> Vector:
        y = np.zeros(2 * self.count)
        self.modes[:] = 0.0
        for effort in switching()[:, 0]:
            self.effort, t, end = float(effort), 0.0, PEER_SECONDS / SWITCHES
            self.settle(y, None, None)
            while t < end:
                found = solve_ivp(
                    self.rates,
                    (t, end),
                    y,
                    method="DOP853",
                    rtol=rtol,
                    atol=atol,
                    events=self.events(),
                )
                t, y = float(found.t[-1]), found.y[:, -1].copy()
                hit = [i for i, times in enumerate(found.t_events) if times.size]
                if found.status == 1:
                    first = hit[0]
                    self.settle(y, *((first, None) if self.modes[first] != 0.0 else (None, first)))
        return y[: self.count]

    def events(self) -> list[Any]:
        made = []
        for i in range(self.count):
            mode = self.modes[i]
            if mode == 0.0:

                def event(_: float, y: Vector, i: int = i) -> float:
                    return BREAKAWAY - abs(float(self.pull(y)[i]))
            else:

                def event(_: float, y: Vector, i: int = i, mode: float = mode) -> float:
                    return float(mode * y[self.count + i])

            event.terminal, event.direction = True, -1.0
            made.append(event)
        return made


def _against(peer: str, call: Callable[[], Vector], rounds: int) -> dict[str, Any]:
    b = chain(20, 0)
    exact = player(b, switching(), PEER_SECONDS / SWITCHES, 1e-12)().positions[:, -1]
    way = float(
        np.ptp(
            player(b, np.repeat(switching(), 50, axis=0), PEER_SECONDS / SWITCHES / 50)().positions[
                0
            ]
        )
    )
    engine = player(b, switching(), PEER_SECONDS / SWITCHES)
    ours, theirs = pair(engine, call, rounds)
    errors = [
        float(np.max(np.abs(found - exact))) / way for found in (engine().positions[:, -1], call())
    ]
    accuracy = f"{errors[0]:.1e} of the way against {errors[1]:.1e}"
    return {
        "peer": peer,
        "ours": ours,
        "theirs": theirs,
        "unit": "s",
        "ratio": theirs / ours,
        "accuracy": accuracy,
    }


def mechanism_solve_ivp() -> dict[str, Any]:
    """Return the row of 0.1 s of the chain without play against scipy's DOP853.

    The tolerances give DOP853 an accuracy like the engine's. `Switching` contains its events.
    """
    return _against("scipy solve_ivp", lambda: Switching(20).play(1e-7, 1e-9), 1)


def mechanism_mujoco() -> dict[str, Any]:
    """Return the row against MuJoCo, with friction loss in the joints and tendons as springs.

    MuJoCo's friction has no breakaway, and creeps.
    """
    import mujoco

    joints = "".join(
        f'<body><joint name="j{i}" type="slide" axis="1 0 0" damping="{VISCOUS}" '
        f'frictionloss="{COULOMB}"/>'
        f'<geom size=".01" mass="{MASS}" contype="0" conaffinity="0"/></body>'
        for i in range(20)
    )
    springs = "".join(
        f'<fixed stiffness="{STIFFNESS}" damping="{DAMPER}" springlength="0">'
        f'<joint joint="j{i}" coef="-1"/><joint joint="j{i + 1}" coef="1"/></fixed>'
        for i in range(19)
    )
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{MUJOCO_STEP}" gravity="0 0 0" '
        f'integrator="implicitfast"/><worldbody>{joints}</worldbody>'
        f'<tendon>{springs}</tendon><actuator><motor joint="j0"/></actuator></mujoco>'
    )
    data = mujoco.MjData(model)

    def call() -> Vector:
        mujoco.mj_resetData(model, data)
        for effort in switching()[:, 0]:
            data.ctrl[0] = effort
            mujoco.mj_step(model, data, nstep=round(PEER_SECONDS / SWITCHES / MUJOCO_STEP))
        return np.array(data.qpos)

    return _against(f"mujoco, steps of {MUJOCO_STEP:g} s", call, ROUNDS)


def gear(inertia: float, stiffness: float, damping_ratio: float) -> Builder:
    """Return a drive and a load of equal inertia [kg m^2] with a gear of a stiffness [N m/rad]."""
    b = Builder()
    b.block(inertia, 10.0)
    b.block(inertia, 10.0)
    b.coupling(0, 1, stiffness, damping_ratio * np.sqrt(2.0 * stiffness * inertia), -1.0)
    b.source(0)
    return b


def mechanism_stiff_link() -> dict[str, Any]:
    """Return the row of the cost of stiff links, relative to a link of 1e5 N m/rad.

    The stiffnesses are 1e8, 1e10 and 1e12 N m/rad, without damping and with a damping ratio of 0.7.
    The largest relative cost must be at most 10.
    """
    worst, parts = 0.0, []
    for inertia in (1e-5, 1e-3):
        for damping_ratio in (0.0, 0.7):
            swing = inertia * 50.0 * np.sin(2.0 * np.pi * 20.0 * PERIOD * np.arange(50))[:, None]
            seconds = [
                cost(player(gear(inertia, stiffness, damping_ratio), swing, PERIOD))
                for stiffness in STIFFNESSES
            ]
            ratios = [one / seconds[0] for one in seconds[1:]]
            worst = max(worst, *ratios)
            shown = ", ".join(f"{one:.2g}" for one in ratios)
            parts.append(f"{inertia:g} kg m2, damping ratio {damping_ratio:g}: {shown}")
    return {
        "peer": "1e5 N m/rad, limit 10",
        "ours": worst,
        "theirs": MOST_COST,
        "unit": "times",
        "ratio": MOST_COST / worst,
        "accuracy": "; ".join(parts),
    }


ROWS = [
    mechanism_real_time,
    mechanism_length,
    mechanism_solve_ivp,
    mechanism_mujoco,
    mechanism_stiff_link,
]
for _row in ROWS:
    _row.id = _row.__name__.replace("mechanism_", "mechanism.")

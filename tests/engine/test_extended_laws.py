"""Extensions under the laws that the exact engine does not run: with a state, and printed for a
fixed step."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from frictool.engine.body import BREAKS_AWAY
from frictool.engine.drive import EffortFunction, effort, held, ramped, spring
from frictool.engine.law_simulation import LawRunSettings, body_of, run_law
from frictool.engine.status_codes import OK
from frictool.engine.stick_slip_run import Trajectory, simulate
from frictool.friction.law_extension import FrictionExtension
from frictool.friction.law_registry import LAWS
from studies.rigs.table_3_1 import STRIBECK, TABLE_3_1
from tests.support.plain_laws import static_force

MASS, STEP = 1.0, 4e-5
SPRING = spring(stiffness=2.0, speed=0.1)
EVEN = (1.0, 0.1)
LEVELS = {"coulomb", "breakaway"}  # parameters that an extension scales


def run(
    name: str,
    extension: FrictionExtension,
    drive: EffortFunction,
    end: float,
    times: object = (),
    **changes: float,
) -> Trajectory:
    law = LAWS[name]
    p = law.pack({**TABLE_3_1[name], **changes})
    found = run_law(law, p, MASS, [(end, drive)], times, LawRunSettings(STEP, extension=extension))
    assert found.status == OK
    return found


@pytest.mark.parametrize(
    "extension",
    [
        FrictionExtension(fresh=0.7, rise_time=1.0),
        FrictionExtension(forward=EVEN, backward=EVEN, travel=(-1.0, 3.0)),
        FrictionExtension(regimes=((0.1, 0.4),)),
        FrictionExtension(lag=5e-3),
        FrictionExtension(boundary=5e-4),
    ],
    ids=["dwell", "position", "knee", "lag", "boundary"],
)
def test_hybrid_a_is_near_the_exact_engine(extension: FrictionExtension) -> None:
    end = 14.5
    exact = simulate(
        body_of(LAWS["stribeck"], LAWS["stribeck"].pack(STRIBECK), MASS, extension),
        [(end, SPRING)],
        [],
    ).times_of(BREAKS_AWAY)
    found = run("hybrid_a", extension, SPRING, end).times_of(BREAKS_AWAY)
    assert exact.size == 2
    np.testing.assert_allclose(found, exact, rtol=0.0, atol=5e-3)


@pytest.mark.parametrize("name", ["hybrid_a", "hybrid_b", "hybrid_c", "svc_band", "karnopp"])
def test_a_rest_makes_the_breakaway_of_fixed_step_laws_rise(name: str) -> None:
    """Where a ramp meets the hyperbola: r t (tau + t) = F_s (t + fresh tau); presliding and band
    let it wait (3 s and more without extension)."""
    rate, fresh, rise = 0.5, 0.7, 0.6
    b = rate * rise - 1.5
    expected = (-b + math.sqrt(b * b + 4.0 * rate * 1.5 * fresh * rise)) / (2.0 * rate)
    found = run(name, FrictionExtension(fresh=fresh, rise_time=rise), ramped(0.0, rate), 3.2)
    first = float(found.times_of(BREAKS_AWAY)[0])
    assert -1e-3 < first - expected < 0.15


@pytest.mark.parametrize("name", sorted(LAWS))
def test_any_law_slips_steadily_at_the_level_of_its_place_and_regime(name: str) -> None:
    """A pushed mass slips: the friction is the equation of a static law, F_c + sigma_v v of
    others, with F_c and F_s scaled over the position, and the knee's part."""
    forward = (1.0, 0.05)
    extension = FrictionExtension(
        forward=forward, backward=forward, travel=(-2.0, 0.5), regimes=((0.05, 0.6),)
    )
    times = np.linspace(2.4, 3.0, 11)
    changes = {"elastic_limit": 3e-6} if name == "elasto_plastic" else {}
    found = run(name, extension, EffortFunction(offset=1.8, derivative=2.0), 3.0, times, **changes)
    q, v = TABLE_3_1[name], found.velocity
    assert np.all(v > 0.1)
    factor = 1.0 + 0.05 * np.minimum(found.position, 0.5)
    law = name if LAWS[name].kind == "static" else "svc"
    slips = [
        static_force(law, speed, q | {key: q[key] * share for key in LEVELS & q.keys()})
        for speed, share in zip(v, factor, strict=True)
    ]
    excess = (found.friction - 0.6 * np.maximum(0.0, v - 0.05) - slips) / factor
    if (
        name == "elasto_plastic"
    ):  # steady slip is at alpha(z) sigma_0 z = g, above the curve: docs/theory/friction.md
        assert np.all((excess > 0.0) & (excess < 0.5))
        assert np.ptp(excess) < 0.02
    else:
        np.testing.assert_allclose(excess, 0.0, rtol=0.0, atol=1e-3)


def test_a_pure_delay_takes_the_friction_of_the_velocity_of_n_steps_ago() -> None:
    steps = 5
    times = np.arange(0.0, 0.4, STEP)
    found = run(
        "hybrid_a",
        FrictionExtension(delay=steps * STEP),
        EffortFunction(offset=1.6, amplitude=0.3, frequency=40.0),
        0.4,
        times,
    )
    slips = np.flatnonzero(found.mode != 0.0)
    k = slips[(slips > slips[0] + steps) & (np.abs(found.velocity[slips]) > 0.0)]
    ago = found.velocity[k - steps]
    expected = 1.0 + 0.5 * np.exp(-((ago / 1e-3) ** 2)) + 0.4 * found.velocity[k]
    np.testing.assert_allclose(found.friction[k], expected, rtol=1e-12)
    assert np.ptp(expected) > 0.2


def test_lugre_agrees_with_a_stiff_integrator_of_the_formulae() -> None:
    """Levels by direction and place, written out."""
    q, end = TABLE_3_1["lugre"], 0.5
    extension = FrictionExtension(
        {"coulomb": 0.7}, (1.0, 2.0), (1.2, -1.0), (-0.05, 0.05), regimes=((0.05, 3.0),)
    )
    drive = EffortFunction(offset=0.3, amplitude=2.5, frequency=14.0, proportional=2.0)
    array = drive.as_array()

    def field(t: float, y: np.ndarray) -> list[float]:
        x, v, z = y.tolist()
        place = min(max(x, -0.05), 0.05)
        factor, coulomb = (1.0 + 2.0 * place, 1.0) if v >= 0.0 else (1.2 - place, 0.7)
        g = factor * (coulomb + (1.5 - coulomb) * math.exp(-((v / 1e-3) ** 2)))
        slipped = v - q["stiffness"] * abs(v) * z / g
        friction = (
            q["stiffness"] * z
            + q["damping"] * slipped
            + 0.4 * v
            + math.copysign(3.0 * max(0.0, abs(v) - 0.05), v)
        )
        return [v, (effort(t, x, v, 0.0, array) - friction) / MASS, slipped]

    exact = solve_ivp(
        field,
        (0.0, end),
        np.zeros(3),
        method="LSODA",
        rtol=1e-9,
        atol=[1e-12, 1e-10, 1e-13],
        max_step=1e-3,
    ).y[:, -1]
    found = run("lugre", extension, drive, end)
    np.testing.assert_allclose(found.state[:2], exact[:2], rtol=1e-4, atol=1e-8)


@pytest.mark.parametrize("name", sorted(LAWS))
def test_an_extension_that_changes_nothing_gives_the_plain_run(name: str) -> None:
    law = LAWS[name]
    p = law.pack(TABLE_3_1[name])
    plain = run_law(law, p, MASS, [(0.5, held(1.7))], [0.5], LawRunSettings(STEP))
    extended = run_law(
        law,
        p,
        MASS,
        [(0.5, held(1.7))],
        [0.5],
        LawRunSettings(STEP, extension=FrictionExtension(travel=(0.0, 2.0))),
    )
    np.testing.assert_allclose(extended.samples, plain.samples, rtol=1e-6, atol=1e-12)


def test_what_a_law_does_not_take_is_one_line() -> None:
    for name, extension, match in (
        ("dahl", FrictionExtension(rise_time=1.0, fresh=0.9), "dahl never rests"),
        ("coulomb", FrictionExtension(rise_time=1.0, fresh=0.9), "coulomb has no breakaway"),
        ("lugre", FrictionExtension(lag=1.0), "does not support a lubricant film"),
        (
            "elasto_plastic",
            FrictionExtension(forward=(1.0, -0.2), backward=(1.0, -0.2)),
            "elastic_limit is 9e-06",
        ),
        (
            "leuven",
            FrictionExtension(backward_values={"coulomb": 0.5}),
            "more energy than was stored",
        ),
        (
            "coulomb",
            FrictionExtension(backward_values={"viscous": 0.5}),
            "coulomb has no parameter viscous",
        ),
    ):
        with pytest.raises(ValueError, match=match):
            run(name, extension, SPRING, 1.0)
    assert replace(FrictionExtension()).plain

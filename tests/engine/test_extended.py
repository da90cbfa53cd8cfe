"""The exact engine with extended friction: against a slow integrator, against its own plain run,
and what must hold of any run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.engine.body import BOUNCES, BREAKS_AWAY, PASSES_KNEE, SLIPS_BACK, FrictionBody, moving
from frictool.engine.drive import EffortFunction, held, pid, ramped, spring
from frictool.engine.law_simulation import LawRunSettings, body_of, run_law
from frictool.engine.stick_slip_run import simulate
from frictool.friction.law_extension import FrictionExtension
from frictool.friction.law_registry import LAWS
from studies.references.extended_friction import MASS, Slow
from studies.rigs.table_3_1 import STRIBECK
from tests.engine.drives import drives, ok

LAW = LAWS["stribeck"]
P = LAW.pack(STRIBECK)
SPRING = spring(stiffness=2.0, speed=0.1)
PID = pid(proportional=3.0, derivative=6.0, integral=4.0, target=1.0)
EXTENSIONS = {
    "dwell": FrictionExtension(fresh=0.7, rise_time=1.0),
    "position": FrictionExtension(
        forward=(1.0, 0.1, -0.02), backward=(1.2, -0.1), travel=(-1.0, 3.0)
    ),
    "backward": FrictionExtension(
        backward_values={"coulomb": 0.6, "breakaway": 0.9, "viscous": 0.2}
    ),
    "lag": FrictionExtension(lag=5e-3),
    "boundary": FrictionExtension(boundary=5e-4),
    "knee": FrictionExtension(regimes=((0.1, 0.4), (0.2, -0.3))),
    "all": FrictionExtension(
        {"coulomb": 0.8},
        (1.0, 0.05),
        (1.1, -0.05),
        (-2.0, 2.0),
        fresh=0.8,
        rise_time=0.5,
        regimes=((0.1, 0.2),),
        lag=2e-3,
        boundary=2e-4,
    ),
}


def body(extension: FrictionExtension, **changes: object) -> FrictionBody:
    return replace(body_of(LAW, P, MASS, extension), **changes)


@pytest.mark.parametrize(
    ("name", "drive", "end"),
    [
        *(
            pytest.param(
                *(name, drive, end),
                id=f"{name}-{kind}",
                marks=() if name == "all" else pytest.mark.accept,
            )
            for name in EXTENSIONS
            for kind, drive, end in (("spring", SPRING, 16.0), ("pid", PID, 12.0))
        ),
    ],
)
def test_agrees_with_an_integrator(name: str, drive: EffortFunction, end: float) -> None:
    expected, last = Slow(EXTENSIONS[name], drive).breakaways(end)
    run = ok(simulate(body(EXTENSIONS[name]), [(end, drive)], [end]))
    found = np.sort(np.concatenate([run.times_of(BREAKS_AWAY), run.times_of(SLIPS_BACK)]))
    assert len(expected) >= 1
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(run.state[[0, 1, 2]], last[:3], rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("name", EXTENSIONS)
def test_the_sampled_friction_is_what_slows_the_mass(name: str) -> None:
    """m v' = u - F along a slip, with v' from differences of the samples."""
    start = ok(simulate(body(EXTENSIONS[name]), [(16.0, SPRING)], [])).times_of(BREAKS_AWAY)[0]
    times = start + 1e-3 + 1e-4 * np.arange(4000)
    found = ok(simulate(body(EXTENSIONS[name]), [(16.0, SPRING)], times))
    effort = 2.0 * (0.1 * times - found.position)
    slips = np.abs(found.velocity) > 1e-3
    smooth = slips & np.roll(slips, 1) & np.roll(slips, -1)
    smooth[[0, -1]] = False
    gap = MASS * np.gradient(found.velocity, times) - (effort - found.friction)
    assert np.count_nonzero(smooth) > 1000
    assert np.quantile(np.abs(gap[smooth]), 0.99) < 1e-4


extensions = st.builds(
    FrictionExtension,
    backward_values=st.builds(
        lambda c, more: {"coulomb": c, "breakaway": c * more},
        st.floats(0.2, 2.0),
        st.floats(1.4, 2.0),
    ),
    forward=st.tuples(st.floats(0.6, 1.5), st.floats(-0.15, 0.15)),
    backward=st.tuples(st.floats(0.6, 1.5), st.floats(-0.15, 0.15)),
    travel=st.just((-3.0, 3.0)),
    fresh=st.floats(0.72, 1.0),
    rise_time=st.floats(1e-3, 5.0),
    regimes=st.lists(st.floats(0.0, 1.0), max_size=3).map(
        lambda slopes: tuple((0.05 * (k + 1), s) for k, s in enumerate(slopes))
    ),
    lag=st.sampled_from([0.0, 1e-3, 2e-2]),
    boundary=st.sampled_from([0.0, 5e-4]),
)


@given(
    extension=extensions,
    first=drives,
    second=drives,
    start=st.floats(-1.0, 1.0),
    restitution=st.sampled_from([0.0, 0.7]),
)
def test_energy_is_never_created(
    extension: FrictionExtension,
    first: EffortFunction,
    second: EffortFunction,
    start: float,
    restitution: float,
) -> None:
    """Friction only takes (3.42), through every switch; at rest nothing moves and the threshold is
    not passed."""
    bounded = body(extension, stops=(-3.0, 3.0), restitution=restitution)
    times = np.linspace(0.0, 2.0, 20_001)
    run = ok(simulate(bounded, [(1.0, first), (2.0, second)], times, state=moving(0.0, start)))
    assert np.all(run.friction * run.velocity >= 0.0)
    assert np.all(np.abs(run.position) <= 3.0 + 1e-12)
    still = run.mode == 0.0
    assert np.all(run.velocity[still] == 0.0)
    power = run.effort * run.velocity
    work = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(times))])
    kinetic = 0.5 * MASS * run.velocity**2
    trapezoid = 1e-4 * np.max(np.abs(power)) * (3 + run.events.shape[0])
    assert np.all(kinetic <= kinetic[0] + work + trapezoid)


@given(drive=drives, start=st.floats(-1.0, 1.0))
def test_an_extension_that_changes_next_to_nothing_gives_the_plain_run(
    drive: EffortFunction, start: float
) -> None:
    """Adaptive steps everywhere against closed forms above the layer: two ways to the same
    motion."""
    same = body(FrictionExtension(rise_time=1e-12))
    plain = ok(simulate(body(FrictionExtension()), [(2.0, drive)], [2.0], state=moving(0.0, start)))
    extended = ok(simulate(same, [(2.0, drive)], [2.0], state=moving(0.0, start)))
    np.testing.assert_allclose(extended.state[:3], plain.state[:3], rtol=1e-5, atol=1e-6)


@given(extension=extensions, drive=drives, start=st.floats(-1.0, 1.0))
def test_a_run_is_one_and_cut_anywhere_goes_on(
    extension: FrictionExtension, drive: EffortFunction, start: float
) -> None:
    """(3.5): from one state goes one motion. Twice the same bytes; in parts, the whole; mirrored,
    if the directions change places."""
    whole = ok(simulate(body(extension), [(2.0, drive)], [2.0], state=moving(0.0, start)))
    again = ok(simulate(body(extension), [(2.0, drive)], [2.0], state=moving(0.0, start)))
    assert again.state.tobytes() == whole.state.tobytes()
    assert again.events.tobytes() == whole.events.tobytes()
    part = ok(simulate(body(extension), [(0.7, drive)], [0.7], state=moving(0.0, start)))
    rest = ok(simulate(body(extension), [(2.0, drive)], [2.0], state=part.state, start=0.7))
    np.testing.assert_allclose(rest.state[:3], whole.state[:3], rtol=1e-5, atol=2e-6)
    values = {name: STRIBECK[name] for name in ("coulomb", "breakaway")}
    turned = replace(
        extension,
        backward_values=values,
        forward=tuple(b * (-1.0) ** k for k, b in enumerate(extension.backward)),
        backward=tuple(b * (-1.0) ** k for k, b in enumerate(extension.forward)),
    )
    other = body_of(LAW, LAW.pack({**STRIBECK, **extension.backward_values}), MASS, turned)
    mirror = EffortFunction(
        -drive.offset,
        -drive.slope,
        -drive.amplitude,
        *drive[3:8],
        -drive.target,
        -drive.target_speed,
    )
    mirrored = ok(simulate(other, [(2.0, mirror)], [2.0], state=moving(0.0, -start)))
    np.testing.assert_allclose(mirrored.state[:3], -whole.state[:3], rtol=0.0, atol=1e-9)


@given(
    fresh=st.floats(0.7, 1.0),
    rise_time=st.floats(1e-3, 10.0),
    rate=st.floats(1e-3, 10.0),
    place=st.floats(-3.0, 3.0),
)
def test_the_breakaway_is_that_of_the_place_and_of_the_time_at_rest(
    fresh: float, rise_time: float, rate: float, place: float
) -> None:
    """A ramp meets the hyperbola where r t (tau + t) = F (t + fresh tau): the root of a quadratic,
    by hand."""
    factor = (1.0, 0.1)
    extension = FrictionExtension(
        forward=factor, backward=factor, travel=(-2.0, 2.0), fresh=fresh, rise_time=rise_time
    )
    level = 1.5 * (1.0 + 0.1 * min(max(place, -2.0), 2.0))
    b = rate * rise_time - level
    expected = (-b + np.sqrt(b * b + 4.0 * rate * level * fresh * rise_time)) / (2.0 * rate)
    start = np.array([place, 0.0, 0.0, 0.0, 0.0])
    run = ok(simulate(body(extension), [(2.0 * level / rate, ramped(0.0, rate))], [], state=start))
    assert run.times_of()[0] == pytest.approx(expected, rel=1e-12)
    below = ok(
        simulate(
            body(extension), [(100.0, held(fresh * level * (1.0 - 1e-9)))], [100.0], state=start
        )
    )
    assert below.events.size == 0
    assert below.position[0] == place


def test_a_slower_ramp_breaks_away_later_and_at_more() -> None:
    forces = []
    for rate in (10.0, 1.0, 0.1, 0.01):
        run = ok(simulate(body(EXTENSIONS["dwell"]), [(2.0 / rate, ramped(0.0, rate))], []))
        forces.append(rate * run.times_of()[0])
    assert np.all(np.diff(forces) > 0.01)
    assert 0.7 * 1.5 < forces[0] < forces[-1] < 1.5


def test_stick_slip_shrinks_as_the_pull_gets_faster() -> None:
    """Shorter sticks, smaller breakaways, smaller jumps of the spring's force: what rising static
    friction is known for."""
    swings = []
    for speed in (0.01, 0.03, 0.1, 0.3):
        run = ok(
            simulate(body(EXTENSIONS["dwell"]), [(60.0 / (speed / 0.1), spring(2.0, speed))], [])
        )
        at = run.events[run.events[:, 1] == BREAKS_AWAY]
        swings.append(
            2.0 * float(np.max(speed * at[2:, 0] - at[2:, 2])) if at.shape[0] > 2 else 0.0
        )
    assert np.all(np.diff(swings) < 0.0)


def test_a_film_lets_go_more_easily_just_after_a_stop() -> None:
    """The friction of a fast slip lasts for a lag: pushed again at once a body leaves under less
    than its breakaway, and later does not."""
    lagging = body(FrictionExtension(lag=0.05))
    stop = ok(simulate(lagging, [(2.0, held(0.0))], [], state=moving(0.0, 0.3)))
    at = float(stop.events[-1, 0]) + 1e-3
    now = ok(
        simulate(lagging, [(at, held(0.0)), (at + 1.0, held(1.2))], [], state=moving(0.0, 0.3))
    )
    waiting = ok(
        simulate(
            lagging, [(at + 1.0, held(0.0)), (at + 2.0, held(1.2))], [], state=moving(0.0, 0.3)
        )
    )
    assert now.times_of(BREAKS_AWAY).size + now.times_of(SLIPS_BACK).size == 1
    assert waiting.times_of(BREAKS_AWAY).size == 0


def test_knees_and_end_stops_are_events() -> None:
    run = ok(simulate(body(EXTENSIONS["knee"]), [(20.0, held(1.6))], [20.0]))
    assert run.times_of(PASSES_KNEE).size == 2
    friction = (
        1.0 + 0.4 * run.velocity[0] + 0.4 * (run.velocity[0] - 0.1) - 0.3 * (run.velocity[0] - 0.2)
    )
    assert run.friction[0] == pytest.approx(friction, rel=1e-9)
    walled = ok(
        simulate(
            body(EXTENSIONS["all"], stops=(-1.0, 0.2), restitution=0.5), [(10.0, held(2.5))], [10.0]
        )
    )
    assert walled.times_of(BOUNCES).size > 3
    assert (walled.position[0], walled.velocity[0]) == (0.2, 0.0)


def test_what_a_body_does_not_take_is_refused() -> None:
    with pytest.raises(ValueError, match="found a knee of the body"):
        body(EXTENSIONS["dwell"], knee=0.5).as_array()
    settings = LawRunSettings(extension=FrictionExtension(delay=1e-3))
    with pytest.raises(ValueError, match="found a pure delay of the film"):
        run_law(LAW, P, MASS, [(1.0, SPRING)], [1.0], settings)
    with pytest.raises(ValueError, match="falls to"):
        body(FrictionExtension(forward=(1.0, 1.0), travel=(-2.0, 0.0)))
    with pytest.raises(ValueError, match="does not support a lubricant film"):
        body_of(
            LAWS["coulomb_tanh"],
            LAWS["coulomb_tanh"].pack({"coulomb": 1.0, "smoothing_velocity": 1e-3}),
            MASS,
            FrictionExtension(lag=1.0),
        )

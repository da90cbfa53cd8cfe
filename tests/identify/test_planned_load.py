"""Effect of a declared load on `assess` and `excite`: remaining effort, columns of the information,
methods that know the load."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.documents.bench import Bench
from frictool.documents.load_terms import LoadTerms, Term
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.errors import NoSolutionError
from frictool.identify.assess.assessment import assess
from frictool.identify.assess.assessment_inputs import AssessmentRequest
from frictool.identify.excite.bench_limits import axis_known, limits_of, sensing_of
from frictool.identify.excite.cramer_rao import PlannedStroke, cramer_rao, regressors
from frictool.identify.excite.excitation_kinds import ExcitationSettings, excite
from frictool.identify.excite.half_sines import TOP_SHARE
from studies.command_line import run
from studies.rigs.identification_rigs import CLUTCH, EMPS, clutch
from tests.support.command_line import refused

DURATION = 30.0
STROKES = [PlannedStroke(speed, 50.0, 10.0) for speed in (80.0, 160.0, 320.0)]


def loaded(bench: Bench, *terms: Term, most: float | None = None) -> Bench:
    size = None if most is None else Quantity(most, unit="N m" if bench.axis == "rotary" else "N")
    return msgspec.structs.replace(bench, load=LoadTerms(("offset", *terms), most=size))


def test_the_load_is_taken_off_the_effort() -> None:
    """0.2 of 0.64 N m: the reference asks for so much less, and the ramps rise by so much more."""
    plain, heavy = clutch(), loaded(clutch(), "gravity", most=0.2)
    assert limits_of(plain).acceleration(0.0) - limits_of(heavy).acceleration(0.0) == pytest.approx(
        0.2 / limits_of(plain).inertia
    )
    limits = limits_of(heavy)
    for kind in ("sine", "sines", "steps", "multisine"):
        x, v, a = excite(kind, heavy, ExcitationSettings()).columns.values()
        needed = np.abs(
            limits.inertia * a + limits.viscous * v + np.sign(v) * (limits.coulomb + 0.2)
        )
        assert needed.max() <= limits.effort
        assert np.ptp(x) > 0.0
    ramps = [
        excite("breakaway", bench, ExcitationSettings(repetitions=1)).figures["top"]
        for bench in (plain, heavy)
    ]
    assert ramps[1] - ramps[0] == pytest.approx(
        1.1 * 0.2 / heavy.actuator.constant.interval[0], rel=1e-6
    )


def test_a_load_that_takes_all_is_refused() -> None:
    with pytest.raises(NoSolutionError, match="friction and load need up to"):
        limits_of(loaded(clutch(), "spring", most=0.6))
    with pytest.raises(
        NoSolutionError,
        match=f"friction and load need up to .* {100 * TOP_SHARE:g} % of the drive's largest",
    ):
        excite("sine", loaded(clutch(), "spring", most=0.41), ExcitationSettings())
    with pytest.raises(
        NoSolutionError, match=r"drive: the test needs .* allowed: at most 50 \(actuator.limit\)"
    ):
        excite(
            "sine",
            loaded(clutch(), "spring", most=0.3),
            ExcitationSettings(speed=350.0, amplitude=9.0),
        )


@pytest.mark.parametrize("term", ["spring", "gravity", "viscous_by_direction"])
def test_the_bound_is_that_of_the_whole_regression(term: Term) -> None:
    """Against the plain inverse of G'V^-1 G of both directions with white noise of the effort; and
    a column more never tells more."""
    bench = loaded(clutch(), term)
    axis, sensing = axis_known(bench), sensing_of(bench)
    exact = sensing.__class__(
        sensing.period, 1e-12, sensing.noise
    )  # no error of the encoder: V is sensing.noise^2
    total = sum(
        s.times * (g.T @ g)
        for s in STROKES
        for side in (1.0, -1.0)
        for g in [regressors(s, axis, exact, side)]
    )
    bound = sensing.noise * np.sqrt(np.diag(np.linalg.inv(total)))[:4]
    found, without = (
        cramer_rao(STROKES, axis, exact),
        cramer_rao(STROKES, axis_known(clutch()), exact),
    )
    assert found == pytest.approx(bound, rel=1e-3)
    assert np.all(found >= without * (1.0 - 1e-9))
    assert np.any(found > 1.01 * without)


def test_columns_are_those_of_the_positions() -> None:
    bench = msgspec.structs.replace(clutch(), load=LoadTerms(("spring", "gravity")))  # no offset
    axis, sensing, stroke = axis_known(bench), sensing_of(bench), STROKES[0]
    assert axis.middle == pytest.approx(31.5)
    for side in (1.0, -1.0):
        g = regressors(stroke, axis, sensing, side)
        position = g[:, 3]
        assert g.shape[1] == 6
        assert np.all(side * np.diff(position) > 0.0)
        assert position[-1] == pytest.approx(axis.middle + side * 0.5 * stroke.distance, abs=0.2)
        assert np.diff(position) / sensing.period == pytest.approx(
            0.5 * (g[1:, 1] + g[:-1, 1]), rel=1e-2
        )
        assert np.hypot(g[:, 4], g[:, 5]) == pytest.approx(1.0)
    assert cramer_rao(STROKES, axis, sensing)[3] == 0.0


def test_what_does_not_know_the_load_is_not_promised() -> None:
    found = {
        row.parameter: row.verdict
        for row in assess(
            loaded(clutch(), "gravity", most=0.1), AssessmentRequest(duration=DURATION)
        ).rows
    }
    assert found["inertia"].method is None
    assert "the weak form cannot fit load.terms" in found["inertia"].why
    assert {found[name].method for name in ("viscous", "coulomb")} == {"least-squares"}
    assert "the method of sines cannot fit load.terms" in found["viscous"].why
    emps = {
        row.parameter: row
        for row in assess(
            loaded(load(EMPS, Bench), "spring", most=5.0), AssessmentRequest(duration=DURATION)
        ).rows
    }
    alone = {
        row.parameter: row
        for row in assess(load(EMPS, Bench), AssessmentRequest(duration=DURATION)).rows
    }
    for name in ("inertia", "viscous", "coulomb"):
        assert emps[name].verdict.method == "least-squares"
        assert emps[name].least > alone[name].least


def test_the_commands_say_what_is_missing(tmp_path: Path) -> None:
    bench = tmp_path / "bench.yaml"
    bench.write_text(CLUTCH.read_text() + "\nload: {terms: [offset, gravity]}\n")
    missing = "load.terms contains gravity, but load.most is missing"
    assert missing in run("assess", "--bench", bench).stderr
    assert (
        missing
        in run("excite", "--bench", bench, "--kind", "sine", "-o", tmp_path / "sine.csv").stderr
    )
    bench.write_text(
        CLUTCH.read_text() + "\nload: {terms: [offset, gravity], most: {value: 100, unit: mN m}}\n"
    )
    assert (
        "load."
        not in run("excite", "--bench", bench, "--kind", "sine", "-o", tmp_path / "sine.csv").stderr
    )
    bench.write_text(
        CLUTCH.read_text() + "\nload: {terms: [offset], most: {value: 0.1, unit: N m}}\n"
    )
    refused(
        run("assess", "--bench", bench),
        3,
        "most: this key limits spring, gravity, ripple, but no such term is listed",
    )

"""Sines, breakaway and the friction map at full count: errors, and whether the intervals hold at
the rate that they state.

A coverage of the breakaway is judged against the binomial distribution at the stated rate: it fails
where so few covers would come by chance once in a thousand runs. More are no failure, since an
interval holds every fall of friction over speed that the encoder does not refute, and most rigs
here have none. The seeds' axes are those of `check_identify`, for the friction map the clutch of
configs/clutch/nonlinear.yaml with its encoder phase and its noise drawn anew. Tables 4.6 and 4.7
are redone on that simulated clutch.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import binom

from frictool.identify.breakaway.breakaway import breakaway
from frictool.identify.breakaway.stribeck_velocity import EXPONENTS
from frictool.identify.estimators.ordinary import ordinary
from frictool.identify.estimators.sines import sines as method_of_sines
from frictool.identify.fit_result import SLIDING, Interval
from frictool.identify.identification import identify_records
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import make_record
from studies.rigs.clutch_friction import BETA, KNEE, TABLE_4_7
from studies.rigs.curve_logs import mass_sines, nonlinear_clutch
from studies.rigs.identification_rigs import MASS, clutch, mass_bench, record
from studies.rigs.sample_logs import PERIOD, SECONDS_EACH, TRUTH, ramp, sines
from tests.support.identification_statistics import CHANCE, FINE_STEP, RATE, experiment
from tests.support.stribeck_rigs import FALLS, found_breakaway

SEEDS, MAP_SEEDS, SINE_SEEDS = 400, 100, 40
FALL_SEEDS = 200


def _rate(hits: list[bool]) -> dict[str, Any]:
    least = int(binom.ppf(CHANCE, len(hits), RATE))
    return {
        "passed": sum(hits) >= least,
        "seeds": len(hits),
        "covered": float(np.mean(hits)),
        "least_accepted": least / len(hits),
    }


def _breakaway_coverage(encoder_step: float) -> dict[str, Any]:
    """The breakaway's interval, all else from sines by `power-balance`, or from the bench where
    that refuses it."""
    hits, errors, halves = [], [], []
    for seed in range(SEEDS):
        truth, bench = experiment(seed, encoder_step)
        logs = [
            record(make(seed, truth), truth, name)
            for name, make in (("sines", sines), ("ramp", ramp))
        ]
        found = identify_records(logs, [], bench, "power-balance", IdentificationSettings(RATE))
        interval = found.identified["breakaway"]
        hits.append(interval.low <= truth.breakaway <= interval.high)
        errors.append(interval.value / truth.breakaway - 1.0)
        halves.append(interval.half_width / truth.breakaway)
    figures = {
        "rms_percent": 100.0 * float(np.sqrt(np.mean(np.square(errors)))),
        "half_percent": 100.0 * float(np.mean(halves)),
    }
    return {**_rate(hits), **figures, "mean_percent": 100.0 * float(np.mean(errors))}


def breakaway_coarse() -> dict[str, Any]:
    """Encoder of 56 points: the bench's range of the inertia is most of the interval."""
    return _breakaway_coverage(TRUTH.encoder_step)


def breakaway_fine() -> dict[str, Any]:
    """Encoder of 4096 points."""
    return _breakaway_coverage(FINE_STEP)


def breakaway_known() -> dict[str, Any]:
    """Encoder of 56 points and an axis that is known: the statistical part of the interval
    alone."""
    hits = []
    for seed in range(SEEDS):
        truth, bench = experiment(seed)
        known = {name: Interval(*[getattr(truth, name)] * 3) for name in SLIDING}
        interval = breakaway([record(ramp(seed, truth), truth)], bench, known, RATE).interval
        hits.append(interval.low <= truth.breakaway <= interval.high)
    return _rate(hits)


def _fall_coverage(fall: str, exponent: float) -> dict[str, Any]:
    """The breakaway's interval on random rigs whose other parameters are known; error of the value
    and half width in per cent of it."""
    hits, errors, halves = [], [], []
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(FALL_SEEDS):
            axis, found = found_breakaway(seed, fall, Path(folder), exponent=exponent)
            hits.append(found.interval.low <= axis.breakaway <= found.interval.high)
            errors.append(100.0 * (found.interval.value / axis.breakaway - 1.0))
            halves.append(100.0 * found.interval.half_width / axis.breakaway)
    return {
        **_rate(hits),
        "rms_percent": float(np.sqrt(np.mean(np.square(errors)))),
        "median_half_percent": float(np.median(halves)),
    }


def sines_of_table_4_1() -> dict[str, Any]:
    """Mean errors of the method of sines at most those of the trial, at a count of 1e-4 m and of
    1e-2 m."""
    out: dict[str, Any] = {"passed": True, "seeds": SINE_SEEDS}
    with tempfile.TemporaryDirectory() as folder:
        bench = mass_bench(Path(folder))
    for step, limits in ((1e-4, (0.4, 0.4)), (1e-2, (0.6, 0.9))):
        fits = [
            method_of_sines(mass_sines(seed, step), bench, IdentificationSettings(RATE))
            for seed in range(SINE_SEEDS)
        ]
        for name, limit in zip(("viscous", "coulomb"), limits, strict=True):
            errors = np.array(
                [100.0 * (fit.parameters[name].value / getattr(MASS, name) - 1.0) for fit in fits]
            )
            out[f"{name}_{step:g}_mean_percent"], out[f"{name}_{step:g}_rms_percent"] = (
                float(errors.mean()),
                float(np.sqrt(np.mean(errors**2))),
            )
            out["passed"] &= bool(np.sqrt(np.mean(errors**2)) <= limit)
        out[f"false_knees_{step:g}"] = sum(fit.details["knees"] > 0 for fit in fits)
    return out


def friction_map() -> dict[str, Any]:
    """The non-linear clutch: how often the intervals hold its levels, its knee and what is viscous
    beyond it; errors of beta."""
    truth, bench, hits, betas, orders, powers = nonlinear_clutch(), clutch(), [], [], [], []
    for seed in range(MAP_SEEDS):
        logs = [
            record(make(seed, truth), truth, name)
            for name, make in (("sines", sines), ("ramp", ramp))
        ]
        found = identify_records(logs, [], bench, "sines", IdentificationSettings(RATE))
        assert found.fit is not None
        assert found.laws is not None
        assert found.ramp is not None
        assert found.ramp.by_position is not None
        law, regime = found.ramp.by_position, found.laws.regimes[0]
        assert found.laws.backward is not None
        places = np.linspace(law.low, law.high, 2001)
        mean = {
            side: float(np.mean(np.polynomial.polynomial.polyval(places, np.array(terms))))
            for side, terms in TABLE_4_7.items()
        }
        checks = {
            "breakaway_forward": (law.forward, mean[1.0]),
            "breakaway_backward": (law.backward, mean[-1.0]),
            "coulomb_forward": (found.identified["coulomb"], mean[1.0] / BETA),
            "coulomb_backward": (found.laws.backward.coulomb, mean[-1.0] / BETA),
            "knee": (regime.above, KNEE),
            "viscous_beyond": (regime.viscous, 3.81e-4),
        }
        hits.append(
            {
                name: bool(interval.low <= true <= interval.high)
                for name, (interval, true) in checks.items()
            }
        )
        for side, unsure in zip((1.0, -1.0), law.coefficients, strict=True):
            if len(unsure) == len(TABLE_4_7[side]):
                powers += [
                    one.low <= term <= one.high
                    for one, term in zip(unsure, TABLE_4_7[side], strict=True)
                ]
        betas.append(found.fit.details["beta"])
        orders.append([len(side) - 1 for side in law.powers] == [3, 4])
    rates = {f"covered_{name}": float(np.mean([hit[name] for hit in hits])) for name in hits[0]}
    rates["covered_coefficients"] = float(np.mean(powers))
    beta = 100.0 * float(np.sqrt(np.mean((np.array(betas) / BETA - 1.0) ** 2)))
    share = float(np.mean(orders))
    passed = min(rates.values()) >= 0.88 and beta < 0.5 and share > 0.8
    return {
        "passed": passed,
        "seeds": MAP_SEEDS,
        **rates,
        "beta_rms_percent": beta,
        "orders_of_table_4_7": share,
    }


def tables_4_6_and_4_7() -> dict[str, Any]:
    """On the SIMULATED clutch: least squares on filtered differences finds the filter and not the
    clutch (4.4.2.1); the polynomials.

    Published on the bench: J 1.1834e-7 kg m^2, viscous 7.2469e-5 N m s/rad, Coulomb 0.1395 N m at
    350 rad/s with tau 1.5 ms. Table 4.7 is what the simulated clutch has, so that the found
    coefficients are compared with what was put in, over the ramps' range.
    """
    truth, bench = nonlinear_clutch(), clutch()
    whole = record(sines(1, truth), truth)
    last = slice(whole.time.size - round(SECONDS_EACH / PERIOD), None)
    fast = make_record(
        "350 rad/s",
        whole.time[last],
        whole.position[last],
        whole.effort[last],
        whole.resolution,
        whole.lag,
    )
    found = ordinary([fast], bench, IdentificationSettings(RATE, time_constant=1.5e-3)).parameters
    logs = [whole, record(ramp(1, truth), truth, "ramp")]
    law = identify_records(logs, [], bench, "sines", IdentificationSettings(RATE)).ramp
    assert law is not None
    assert law.by_position is not None
    out: dict[str, Any] = {
        f"table_4_6_{name}": found[name].value
        for name in ("inertia", "viscous", "coulomb")
        if name in found
    }
    places = np.linspace(law.by_position.low, law.by_position.high, 501)
    for side, name, terms in zip(
        (1.0, -1.0), ("forward", "backward"), law.by_position.powers, strict=True
    ):
        out |= {f"table_4_7_b{power}_{name}": term for power, term in enumerate(terms)}
        true, curve = (
            np.polynomial.polynomial.polyval(places, np.array(values))
            for values in (TABLE_4_7[side], terms)
        )
        out[f"rms_{name}_percent"] = 100.0 * float(
            np.sqrt(np.mean((curve - true) ** 2)) / np.mean(true)
        )
    return {"passed": max(out["rms_forward_percent"], out["rms_backward_percent"]) < 1.5, **out}


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {
    "identify: breakaway coverage, 56 points": breakaway_coarse,
    "identify: breakaway coverage, 4096 points": breakaway_fine,
    "identify: breakaway coverage, known axis": breakaway_known,
    **{
        f"identify: breakaway coverage, fall {fall}, exponent {exponent:g}": partial(
            _fall_coverage, fall, exponent
        )
        for fall in FALLS
        for exponent in (EXPONENTS if FALLS[fall] else EXPONENTS[:1])
    },
    "identify: sines of table 4.1": sines_of_table_4_1,
    "identify: friction map": friction_map,
    "identify: tables 4.6 and 4.7, simulated": tables_4_6_and_4_7,
}

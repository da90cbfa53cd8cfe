"""Inputs of the thesis, tables 3.1, 4.1, 4.5, 4.8, 5.1 and 5.2, as stated in the rigs' files."""

from __future__ import annotations

import math
from pathlib import Path

from frictool.adapters.axis_model import axis_of
from frictool.compare.comparison_setting import from_friction
from frictool.documents.bench import Bench
from frictool.documents.design import Design
from frictool.documents.friction import Friction
from frictool.documents.mechanism import Mechanism, Rack
from frictool.documents.model import Model
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from studies.clutch.rig import FILTER
from studies.rigs.identification_rigs import MASS, MASS_NOISE, MASS_PERIOD
from studies.thesis.results import Part

CONFIGS = Path(__file__).parents[3] / "configs"


def inputs() -> Part:
    """Return the part with the inputs that the files of configs/ state."""
    part = Part()
    _table_3_1(part)
    part.add(
        "table_4_1",
        {
            "m": MASS.inertia,
            "sigma_v": MASS.viscous,
            "F_c": MASS.coulomb,
            "F_s": MASS.breakaway,
            "delta_x": MASS.encoder_step,
            "T_s": MASS_PERIOD,
            "noise": MASS_NOISE**2,
        },
    )
    _table_4_8(part)
    _table_5_1(part)
    bench = load(CONFIGS / "clutch/bench.yaml", Bench)
    _table_4_5(part, bench)
    for name, quantity in _ranges(bench).items():
        low, high = quantity.interval
        part.add(
            "table_5_2", {f"{name}.mean": quantity.value, f"{name}.min": low, f"{name}.max": high}
        )
    return part


def _ranges(bench: Bench) -> dict[str, Quantity]:
    """Return the ranges of table 5.2 that the clutch's bench states."""
    mechanics = bench.mechanics
    given = {
        "J": mechanics.inertia,
        "K": bench.actuator.constant,
        "sigma_v": mechanics.viscous,
        "F_c": mechanics.coulomb,
    }
    return {name: quantity for name, quantity in given.items() if quantity is not None}


def _table_4_5(part: Part, bench: Bench) -> None:
    known, limit = _ranges(bench), bench.actuator.limit
    low, high = known["J"].interval
    part.add(
        "table_4_5",
        {
            "J": known["J"].value,
            "J_half": (high - low) / 2.0,
            "C_d": known["F_c"].value,
            "delta_theta": bench.encoder.resolution,
            "K": known["K"].value,
            "T_s": bench.sample_period_s,
            "omega_max": _value(bench.mechanics.top_speed),
            "u_max": _value(limit) * known["K"].value,
            "tau": FILTER,
        },
    )


def _table_3_1(part: Part) -> None:
    found = from_friction(load(CONFIGS / "mass/friction.yaml", Friction))
    part.add(
        "table_3_1",
        {
            "m": found.mass,
            "f_c": found.coulomb,
            "f_s": found.breakaway,
            "v_s": found.stribeck_velocity,
            "delta_s": found.stribeck_exponent,
            "sigma_2": found.viscous,
            "u_max": found.effort_limit,
            "z_max": found.presliding,
            "sigma_0": found.stiffness,
            "sigma_1": found.damping,
            "z_ba": found.plastic_from * found.presliding,
            "Sigma": found.switch_velocity,
            "T_e": found.step,
            "p_0": found.decay,
        },
    )


def _table_4_8(part: Part) -> None:
    """Add table 4.8.

    p0, Sigma and T_s are settings of the hybrid model; an event-exact engine has none.
    """
    clutch = axis_of(load(CONFIGS / "clutch/nonlinear.yaml", Model))
    rack = load(CONFIGS / "clutch/mechanism.yaml", Mechanism).links["rack"]
    assert isinstance(rack, Rack)
    part.add(
        "table_4_8",
        {
            "J": clutch.inertia,
            "beta": clutch.breakaway / clutch.coulomb,
            "backlash": clutch.backlash,
            "delta_theta": clutch.encoder_step,
            "K": clutch.constant,
            "C_r2": clutch.backlash_coulomb,
            "r": rack.radius.value,
        },
    )
    part.say(
        "table_4_8",
        "p0, Sigma and T_s are settings of the hybrid model; frictool's engine of the clutch "
        "solves its events, and has none.",
    )


def _table_5_1(part: Part) -> None:
    mass = load(CONFIGS / "mass/model.yaml", Model)
    designs = {
        name: load(CONFIGS / f"mass/designs/{name}.yaml", Design)
        for name in ("pid_limiter", "pi_p")
    }
    pid, cascade, limiter, law = (
        designs["pid_limiter"].pid,
        designs["pi_p"].pid,
        designs["pid_limiter"].limiter,
        designs["pi_p"].position_law,
    )
    assert pid is not None
    assert pid.gain is not None
    assert cascade is not None
    assert cascade.speed_gain is not None
    assert limiter is not None
    assert law is not None
    limit = mass.bench.actuator.limit
    assert limit is not None
    part.add(
        "table_5_1",
        {
            "m": mass.parameters.inertia.value,
            "f_c": mass.parameters.coulomb.value,
            "f_s": mass.parameters.breakaway.value,
            "T_e": mass.bench.sample_period_s,
            "u_max": limit.value * mass.bench.actuator.constant.value,
            "pid.K": pid.gain.value,
            "pid.T_i": _known(pid.integral_time_s),
            "pid.T_d": _known(pid.derivative_time_s),
            "pid.a": _known(pid.filter_ratio),
            "pi.K": cascade.speed_gain.value,
            "pi.T_i": _known(cascade.integral_time_s),
            "p.K": _known(law.gain_per_s),
            "delta_e": _value(limiter.band),
        },
    )


def _known(value: float | None) -> float:
    return math.nan if value is None else value


def _value(quantity: Quantity | None) -> float:
    return math.nan if quantity is None else quantity.value

"""The table: every law named, packed with clear refusals, run by the one driver of its kind."""

from __future__ import annotations

import math

import numpy as np
import pint
import pytest

from frictool.friction.law import DynamicKernels, HybridKernels, StaticKernels
from frictool.friction.table import LAWS, ROWS
from tests.friction.drivers import dynamic_run, hybrid_run, static_values
from tests.friction.sets import STRIBECK, TABLE_3_1, packed

NAMES = sorted(LAWS)


def test_the_table_lists_each_law_once() -> None:
    assert len(LAWS) == len(ROWS)
    assert set(LAWS) == set(TABLE_3_1)
    assert {law.name for law in ROWS if law.approximation} == {"coulomb_tanh", "coulomb_atan"}


@pytest.mark.parametrize("name", NAMES)
def test_one_driver_per_kind_runs_the_law(name: str) -> None:
    law, p = LAWS[name], packed(LAWS[name])
    if isinstance(law.kernels, StaticKernels):
        rows = static_values(*law.kernels, np.array([-1.0, 0.0, 0.02]), p)
    elif isinstance(law.kernels, DynamicKernels):
        rows = dynamic_run(*law.kernels, np.full(50, 1e-3), 1e-5, p)
    else:
        assert isinstance(law.kernels, HybridKernels)
        rows = hybrid_run(*law.kernels, np.full(50, 2.0), 0.0, 1e-5, p)
    assert np.all(np.isfinite(rows))
    assert law.kind == {StaticKernels: "static", DynamicKernels: "dynamic", HybridKernels: "hybrid"}[type(law.kernels)]


@pytest.mark.parametrize("name", NAMES)
def test_units_are_those_of_force_and_motion(name: str) -> None:
    """Each linear unit becomes the rotary one where N -> N m, m -> rad, kg -> kg m^2."""
    registry = pint.UnitRegistry()
    for parameter in LAWS[name].parameters:
        linear, rotary = (
            registry(part.replace(" ", "*") or "1") if "/" not in part else _ratio(registry, part)
            for part in (parameter.unit_linear, parameter.unit_rotary)
        )
        ratio = (1 * rotary / linear).to_base_units() if hasattr(rotary, "units") else registry("1")
        exponent = dict(ratio.dimensionality).get("[length]", 0)
        assert set(dict(ratio.dimensionality)) <= {"[length]"}
        assert exponent in (-1, 0, 1, 2), parameter.name


def _ratio(registry: pint.UnitRegistry, unit: str) -> pint.Quantity:
    over, under = (registry(part.strip().replace(" ", "*")) for part in unit.split("/"))
    return over / under


@pytest.mark.parametrize("name", NAMES)
def test_parameters_out_of_range_are_refused_in_one_line(name: str) -> None:
    law, good = LAWS[name], TABLE_3_1[name]
    law.pack(good, axis="rotary")
    for parameter in law.parameters:
        for bad in (math.nan, math.inf, parameter.minimum - 1.0, *([parameter.minimum] if parameter.exclusive else [])):
            with pytest.raises(ValueError, match=rf"^{parameter.name} is .*allowed: ") as refusal:
                law.pack({**good, parameter.name: bad})
            assert "\n" not in str(refusal.value)
        if parameter.default is None:
            with pytest.raises(ValueError, match=f"needs {parameter.name}"):
                law.pack({k: v for k, v in good.items() if k != parameter.name})


def test_a_misspelt_parameter_gets_the_nearest_name() -> None:
    with pytest.raises(ValueError, match="stribeck has no parameter strbeck_velocity; did you mean stribeck_velocity"):
        LAWS["stribeck"].pack({"strbeck_velocity": 1.0})
    with pytest.raises(ValueError, match=r"allowed: coulomb$"):
        LAWS["coulomb"].pack({"zzz": 1.0})


def test_a_breakaway_below_coulomb_is_refused() -> None:
    with pytest.raises(ValueError, match=r"breakaway is 0\.9 N m; allowed: >= coulomb, 1 N m"):
        LAWS["stribeck"].pack({**STRIBECK, "breakaway": 0.9}, axis="rotary")


def test_the_printed_elastic_limit_is_refused() -> None:
    """Table 3.1 prints z_ba = 0.009 m where 0.009 mm is meant."""
    with pytest.raises(ValueError, match=r"elastic_limit is 0\.009 m; allowed: < breakaway/stiffness, 1e-05 m"):
        LAWS["elasto_plastic"].pack({**TABLE_3_1["elasto_plastic"], "elastic_limit": 0.009})


def test_a_table_is_taken_only_where_the_law_has_one() -> None:
    with pytest.raises(ValueError, match="coulomb takes no table"):
        LAWS["coulomb"].pack({"coulomb": 1.0}, tail=np.ones(2))
    with pytest.raises(ValueError, match="one row of finite numbers"):
        LAWS["leuven"].pack(TABLE_3_1["leuven"], tail=np.array([1.0, math.nan]))
    longer = LAWS["leuven"].pack(TABLE_3_1["leuven"], tail=np.ones(40))
    assert longer.size == len(LAWS["leuven"].parameters) + 40

"""The table: every law named, packed with clear refusals, run by the one driver of its kind."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from frictool.documents.quantity import factor_to_si
from frictool.friction.law import DynamicKernels, HybridKernels, StaticKernels
from frictool.friction.law_registry import LAWS, ROWS
from studies.rigs.table_3_1 import STRIBECK, TABLE_3_1, packed
from tests.support.law_drivers import dynamic_run, hybrid_run, pointers, static_values

NAMES = sorted(LAWS)


def test_the_table_lists_each_law_once() -> None:
    assert len(LAWS) == len(ROWS)
    assert set(LAWS) == set(TABLE_3_1)


def test_the_documentation_names_every_law() -> None:
    text = (Path(__file__).parents[2] / "docs" / "theory" / "friction.md").read_text(
        encoding="utf-8"
    )
    assert [name for name in NAMES if f"`{name}`" not in text] == []


@pytest.mark.parametrize("name", NAMES)
def test_one_driver_per_kind_runs_the_law(name: str) -> None:
    law, p = LAWS[name], packed(LAWS[name])
    if isinstance(law.kernels, StaticKernels):
        rows = static_values(*pointers(law.kernels), np.array([-1.0, 0.0, 0.02]), p)
    elif isinstance(law.kernels, DynamicKernels):
        rows = dynamic_run(*pointers(law.kernels), np.full(50, 1e-3), 1e-5, p)
    else:
        assert isinstance(law.kernels, HybridKernels)
        rows = hybrid_run(*pointers(law.kernels), np.full(50, 2.0), 0.0, 1e-5, p)
    assert np.all(np.isfinite(rows))
    assert (
        law.kind
        == {StaticKernels: "static", DynamicKernels: "dynamic", HybridKernels: "hybrid"}[
            type(law.kernels)
        ]
    )


UNITS = {  # linear: rotary, dimension in documents
    "N": ("N m", "effort"),
    "N/m": ("N m/rad", None),
    "N s/m": ("N m s/rad", "viscous"),
    "N/s": ("N m/s", None),
    "m": ("rad", "position"),
    "m/s": ("rad/s", "velocity"),
    "kg": ("kg m^2", "inertia"),
    "s": ("s", None),
    "1/s": ("1/s", None),
    "": ("", None),
}


@pytest.mark.parametrize("name", NAMES)
def test_units_are_those_of_the_documents(name: str) -> None:
    for parameter in LAWS[name].parameters:
        rotary, dimension = UNITS[parameter.linear_unit]
        assert parameter.unit("rotary") == rotary
        if dimension is not None:
            assert factor_to_si(parameter.linear_unit, dimension, "linear") == 1.0
            assert factor_to_si(parameter.unit("rotary"), dimension, "rotary") == 1.0


@pytest.mark.parametrize("name", NAMES)
def test_parameters_out_of_range_are_refused_in_one_line(name: str) -> None:
    law, good = LAWS[name], TABLE_3_1[name]
    law.pack(good, axis="rotary")
    for parameter in law.parameters:
        for bad in (
            math.nan,
            math.inf,
            parameter.minimum - 1.0,
            *([parameter.minimum] if parameter.exclusive else []),
        ):
            with pytest.raises(ValueError, match=rf"^{parameter.name} is .*allowed: ") as refusal:
                law.pack({**good, parameter.name: bad})
            assert "\n" not in str(refusal.value)
        if parameter.default is None:
            with pytest.raises(ValueError, match=f"needs {parameter.name}"):
                law.pack({k: v for k, v in good.items() if k != parameter.name})


def test_a_misspelt_parameter_gets_the_nearest_name() -> None:
    with pytest.raises(
        ValueError,
        match="stribeck has no parameter strbeck_velocity; did you mean stribeck_velocity",
    ):
        LAWS["stribeck"].pack({"strbeck_velocity": 1.0})
    with pytest.raises(ValueError, match=r"allowed: coulomb$"):
        LAWS["coulomb"].pack({"zzz": 1.0})


def test_a_breakaway_below_coulomb_is_refused() -> None:
    with pytest.raises(ValueError, match=r"breakaway is 0\.9 N m; allowed: >= coulomb, 1 N m"):
        LAWS["stribeck"].pack({**STRIBECK, "breakaway": 0.9}, axis="rotary")


def test_the_printed_elastic_limit_is_refused() -> None:
    """Table 3.1 prints z_ba = 0.009 m where 0.009 mm is meant."""
    with pytest.raises(
        ValueError, match=r"elastic_limit is 0\.009 m; allowed: < breakaway/stiffness, 1e-05 m"
    ):
        LAWS["elasto_plastic"].pack({**TABLE_3_1["elasto_plastic"], "elastic_limit": 0.009})


def test_a_table_is_taken_only_where_the_law_has_one() -> None:
    with pytest.raises(ValueError, match="coulomb: found a table"):
        LAWS["coulomb"].pack({"coulomb": 1.0}, tail=np.ones(2))
    with pytest.raises(ValueError, match="one row of finite numbers"):
        LAWS["leuven"].pack(TABLE_3_1["leuven"], tail=np.array([1.0, math.nan]))
    longer = LAWS["leuven"].pack(TABLE_3_1["leuven"], tail=np.ones(40))
    assert longer.size == len(LAWS["leuven"].parameters) + 40

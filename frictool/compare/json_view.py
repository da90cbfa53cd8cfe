"""JSON view of a comparison for `frictool compare --json`.

Lengths are in m for a linear axis, and in rad for a rotary axis.
"""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from frictool.compare.comparison import REFERENCE, Comparison, LawResult
from frictool.compare.limit_cycle_criterion import LimitCycleResult
from frictool.compare.stick_slip_criterion import StickSlipResult
from frictool.compare.thesis_tables import PROPERTIES, TESTS
from frictool.documents.quantity import Axis


def as_json(comparison: Comparison) -> dict[str, Any]:
    """Return measures and tables 2.1 and 3.2 by law, and the cells that differ from the thesis."""
    axis = comparison.setting.axis
    return {
        "parameters": asdict(comparison.setting),
        "reference": {
            "law": REFERENCE,
            "stick_slip": _pulled(comparison.reference, axis),
            "limit_cycle": _cycle(comparison.reference_cycle, axis),
        },
        "laws": {name: _law(tested, axis) for name, tested in comparison.laws.items()},
        "tables": {
            "3.2": {
                name: {row: tested.verdicts[row] for row in (*TESTS, "parameters")}
                for name, tested in comparison.laws.items()
            },
            "2.1": {
                name: {row: tested.properties[row] for row in PROPERTIES}
                for name, tested in comparison.laws.items()
            },
        },
        "differences": [asdict(difference) for difference in comparison.differences],
    }


def _unit(axis: Axis) -> str:
    return "rad" if axis == "rotary" else "m"


def _pulled(result: StickSlipResult, axis: Axis) -> dict[str, Any]:
    unit = _unit(axis)
    return {
        "sticks": result.sticks,
        "first_breakaway_s": result.first_breakaway_s,
        "period_s": result.period_s,
        f"jump_{unit}": result.jump,
        "stuck_share": result.stuck_share,
        f"top_speed_{unit}_s": result.top_speed,
    }


def _cycle(result: LimitCycleResult, axis: Axis) -> dict[str, Any]:
    return {
        f"amplitude_{_unit(axis)}": result.amplitude,
        "period_s": result.period_s,
        "lasting": result.lasting,
    }


def _law(result: LawResult, axis: Axis) -> dict[str, Any]:
    return {
        "title": result.title,
        "stick_slip": _pulled(result.stick_slip, axis),
        "limit_cycle": _cycle(result.limit_cycle, axis),
        "presliding": asdict(result.presliding),
        "drift": {
            "z_max_units": result.drift.z_max_units,
            f"displacement_{_unit(axis)}": result.drift.displacement,
        },
        "verdicts": {test: result.verdicts[test] for test in TESTS},
        "properties": result.properties,
    }

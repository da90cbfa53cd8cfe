"""JSON view of a comparison for `frictool compare --json`.

Lengths are in m for a linear axis and in rad for a rotary one.
"""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from frictool.compare.comparison import REFERENCE, Comparison, LawResult
from frictool.compare.limit_cycle_criterion import LimitCycleResult
from frictool.compare.stick_slip_criterion import StickSlipResult
from frictool.compare.thesis_tables import PROPERTIES, TESTS
from frictool.documents.quantity import Axis


def as_json(found: Comparison) -> dict[str, Any]:
    """Return the measures of each law, both tables, and the cells that differ from the print."""
    axis = found.setting.axis
    return {
        "parameters": asdict(found.setting),
        "reference": {
            "law": REFERENCE,
            "stick_slip": _pulled(found.reference, axis),
            "limit_cycle": _cycle(found.reference_cycle, axis),
        },
        "laws": {name: _law(tested, axis) for name, tested in found.laws.items()},
        "tables": {
            "3.2": {
                name: {row: tested.verdicts[row] for row in (*TESTS, "parameters")}
                for name, tested in found.laws.items()
            },
            "2.1": {
                name: {row: tested.properties[row] for row in PROPERTIES}
                for name, tested in found.laws.items()
            },
        },
        "differences": [asdict(difference) for difference in found.differences],
    }


def _unit(axis: Axis) -> str:
    return "rad" if axis == "rotary" else "m"


def _pulled(found: StickSlipResult, axis: Axis) -> dict[str, Any]:
    unit = _unit(axis)
    return {
        "sticks": found.sticks,
        "first_breakaway_s": found.first_breakaway_s,
        "period_s": found.period_s,
        f"jump_{unit}": found.jump,
        "stuck_share": found.stuck_share,
        f"top_speed_{unit}_s": found.top_speed,
    }


def _cycle(found: LimitCycleResult, axis: Axis) -> dict[str, Any]:
    return {
        f"amplitude_{_unit(axis)}": found.amplitude,
        "period_s": found.period_s,
        "lasting": found.lasting,
    }


def _law(found: LawResult, axis: Axis) -> dict[str, Any]:
    return {
        "title": found.title,
        "stick_slip": _pulled(found.stick_slip, axis),
        "limit_cycle": _cycle(found.limit_cycle, axis),
        "presliding": asdict(found.presliding),
        "drift": {
            "z_max_units": found.drift.z_max_units,
            f"displacement_{_unit(axis)}": found.drift.displacement,
        },
        "verdicts": {test: found.verdicts[test] for test in TESTS},
        "properties": found.properties,
    }

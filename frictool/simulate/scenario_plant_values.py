"""Parameter values under `given` of a scenario: check against the plant, and conversion to SI.

A scenario with `variants: given` simulates one plant, which has these parameter values.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping

from frictool.documents.quantity import factor_between
from frictool.documents.scenario import Scenario
from frictool.simulate.document_agreement import DocumentNames, refuse
from frictool.simulate.parameter_order import check_least
from frictool.simulate.simulated_plant import VariedParameter

GIVEN = "given"  # the plant's name, as in `/axis/given`


def check_given(
    scenario: Scenario, ranges: Mapping[str, VariedParameter], names: DocumentNames
) -> None:
    """Raise DocumentError if the scenario's values under `given` do not fit the plant.

    Errors are an unknown name, a wrong unit, and a breakaway friction below the Coulomb friction.
    `ranges` contains the plant's parameters by name.
    """
    for name, quantity in scenario.given.items():
        if name not in ranges:
            near = difflib.get_close_matches(name, ranges, n=1, cutoff=0.5)
            meant = f", did you mean {near[0]!r}?" if near else ""
            refuse(
                names.scenario,
                f"given.{name}",
                f"{names.model} has no such parameter{meant}; allowed: {', '.join(ranges)}",
            )
        try:
            factor_between(quantity.unit, ranges[name].unit)
        except ValueError as error:
            refuse(names.scenario, f"given.{name}.unit", str(error))
    if scenario.variants == GIVEN:
        check_least(ranges, {}, scenario.given, names, drawn=False)


def given_values(scenario: Scenario, ranges: Mapping[str, VariedParameter]) -> dict[str, float]:
    """Return the values [SI] under `given` by parameter name; `check_given` must have passed."""
    return {
        name: factor_between(quantity.unit, ranges[name].unit) * quantity.value
        for name, quantity in scenario.given.items()
    }

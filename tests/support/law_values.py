"""Draws of friction parameters for hypothesis."""

from __future__ import annotations

from hypothesis import strategies as st

from frictool.friction.law import Law
from studies.rigs.table_3_1 import TABLE_3_1


def values(law: Law) -> st.SearchStrategy[dict[str, float]]:
    """Values of the law's parameters, each over two decades around table 3.1, breakaway at least
    Coulomb."""
    centre = {p.name: TABLE_3_1[law.name].get(p.name, p.default) for p in law.parameters}
    draws = {
        name: st.floats(-1.0, 1.0).map(lambda e, c=value or 0.0: c * 10.0**e)
        for name, value in centre.items()
    }

    def ordered(q: dict[str, float]) -> dict[str, float]:
        if "breakaway" in q:
            q["breakaway"] = max(q["breakaway"], q["coulomb"])
        if "stribeck_exponent" in q:
            q["stribeck_exponent"] = min(max(q["stribeck_exponent"], 0.5), 4.0)
        if "elastic_limit" in q:
            q["elastic_limit"] = (
                0.9 * min(1.0, q["elastic_limit"] / 9e-5) * q["breakaway"] / q["stiffness"]
            )
        return q

    return st.fixed_dictionaries(draws).map(ordered)

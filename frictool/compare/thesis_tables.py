"""Tables 2.1 and 3.2 as printed in the thesis, and the reasons why computed cells differ."""

from __future__ import annotations

from dataclasses import dataclass

TESTS = ("stick_slip", "limit_cycle", "presliding", "drift")
PROPERTIES = (
    "dynamic",
    "stiction",
    "rising_static_friction",
    "frictional_memory",
    "presliding",
    "stribeck_effect",
    "viscous",
    "nonlocal_memory",
    "non_drift",
    "parameters",
)
# table 3.2, columns TESTS and the number of parameters
TABLE_3_2: dict[str, tuple[str, ...]] = {
    "lugre": ("+", "+", "±", "-", "7"),
    "elasto_plastic": ("-", "+", "±", "+", "8"),
    "hybrid_a": ("+", "+", "-", "+", "5"),
    "hybrid_b": ("+", "+", "±", "+", "6"),
    "hybrid_c": ("+", "+", "+", "+", ">8"),
}
# table 2.1, columns PROPERTIES; without the last row of the thesis, the speed of simulation, which
# is a property of the integrator (docs/theory/compare.md)
TABLE_2_1: dict[str, tuple[str, ...]] = {
    "coulomb": ("S", "±", "-", "-", "-", "-", "-", "-", "-", "1"),
    "svc": ("S", "±", "-", "-", "-", "-", "+", "-", "-", "4"),
    "stribeck": ("S", "±", "-", "-", "-", "+", "+", "-", "-", "6"),
    "karnopp": ("S", "+", "-", "-", "-", "+", "+", "-", "+", "5"),
    "dahl": ("D", "-", "-", "-", "+", "-", "-", "-", "-", "3"),
    "lugre": ("D", "-", "±", "±", "+", "+", "+", "-", "-", "7"),
    "elasto_plastic": ("D", "-", "±", "±", "+", "+", "+", "-", "+", "8"),
    "leuven": ("D", "-", "±", "±", "+", "+", "+", "+", "+", ">8"),
}
# reasons why a computed cell differs from the printed cell with the parameters of table 3.1, by law
# and then by (row, computed cell); all other cells are equal
OTHER_PARAMETERS = "caused by these parameters; the parameters of table 3.1 give the printed value"
_SMOOTHED = {
    ("non_drift", "+"): (
        "the thesis smooths sign(v); an event-exact simulation of stick has no drift"
    )
}
_SAME_BREAKAWAY = {
    (
        "rising_static_friction",
        "-",
    ): "the breakaway changes by less than 1 % of F_c between forces that grow at 0.1 and 1 N/s"
}
REASONS: dict[str, dict[tuple[str, str], str]] = {
    "coulomb": _SMOOTHED,
    "svc": {
        **_SMOOTHED,
        ("parameters", "3"): "parameters F_c, F_s and sigma_0; the thesis counts one more",
    },
    "stribeck": {
        **_SMOOTHED,
        (
            "parameters",
            "5",
        ): "parameters F_c, F_s, v_s, delta_s and sigma_0; the thesis counts one more",
    },
    "karnopp": {
        ("stribeck_effect", "-"): (
            "section 2.4.2.4 denies the effect; outside Karnopp's band friction grows with speed"
        ),
        ("parameters", "4"): "parameters F_c, F_s, sigma_0 and dv; the thesis counts one more",
    },
    "elasto_plastic": {
        **_SAME_BREAKAWAY,
        (
            "limit_cycle",
            "-",
        ): "the cycles die out according to section 3.7.3 and figure 3.16; the table says "
        "otherwise",
    },
    "leuven": _SAME_BREAKAWAY,
}


@dataclass(frozen=True)
class TableDifference:
    """Table cell with different computed and printed values, and the reason."""

    table: str
    law: str
    row: str
    printed: str
    computed: str
    reason: str


def table_differences(
    verdicts: dict[str, dict[str, str]], properties: dict[str, dict[str, str]]
) -> list[TableDifference]:
    """Return every cell of thesis tables 2.1 and 3.2 in which computed and printed values differ.

    `verdicts`, `properties`: for each law, the symbol in each row.
    """
    differences = []
    for table, rows, printed, computed in (
        ("3.2", (*TESTS, "parameters"), TABLE_3_2, verdicts),
        ("2.1", PROPERTIES, TABLE_2_1, properties),
    ):
        for law, cells in printed.items():
            for row, cell in zip(rows, cells, strict=True):
                here = computed.get(law, {}).get(row)
                if here is not None and not _same(here, cell):
                    differences.append(
                        TableDifference(
                            table,
                            law,
                            row,
                            cell,
                            here,
                            REASONS.get(law, {}).get((row, here), OTHER_PARAMETERS),
                        )
                    )
    return differences


def _same(computed: str, printed: str) -> bool:
    """Return True if the cells agree; `>8` agrees with any number above 8."""
    if printed.startswith(">"):
        return computed.isdigit() and int(computed) > int(printed[1:])
    return computed == printed

"""Table of all friction laws. A new law needs a file, a row in this table, and a test."""

from __future__ import annotations

from frictool.friction import (
    coulomb_atan,
    coulomb_tanh,
    dahl,
    elasto_plastic,
    hybrid_a,
    hybrid_b,
    hybrid_c,
    ideal_coulomb,
    karnopp,
    leuven,
    leuven_masing,
    lugre,
    maxwell_slip,
    stribeck,
    svc,
    svc_band,
)
from frictool.friction.law import Law

ROWS: tuple[Law, ...] = (
    ideal_coulomb.LAW,
    coulomb_tanh.LAW,
    coulomb_atan.LAW,
    svc.LAW,
    svc_band.LAW,
    stribeck.LAW,
    karnopp.LAW,
    dahl.LAW,
    lugre.LAW,
    elasto_plastic.LAW,
    leuven.LAW,
    leuven_masing.LAW,
    maxwell_slip.LAW,
    hybrid_a.LAW,
    hybrid_b.LAW,
    hybrid_c.LAW,
)

LAWS: dict[str, Law] = {law.name: law for law in ROWS}

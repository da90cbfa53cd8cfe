"""Reflected inertia through lossy links: the interval of the model holds the inertia that the whole
mechanism shows when it accelerates and coasts."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from frictool.documents.mechanism import Control, Gear, Link, Mechanism, Source
from frictool.documents.quantity import Quantity
from frictool.errors import NoSolutionError
from frictool.reduce.check_positions import mechanism_positions
from frictool.reduce.coordinate_change import from_reference
from frictool.reduce.reduction_chain import chain
from tests.support.small_mechanisms import coulomb, mechanism, rotor

NEAR, FAR, RATIO, ETA, ETA_BACK = 2e-5, 3e-3, 0.1, 0.8, 0.7
BRUSHES, BEARING, CONSTANT = 0.02, 0.1, 0.05


def geared(back: float = ETA_BACK, brushes: float = BRUSHES) -> Mechanism:
    """Motor, gear that loses a fifth driving and three tenths driven back, wheel in a bearing."""
    links: dict[str, Link] = {
        "gear": Gear(
            ("motor", "wheel"), RATIO, internal=True, efficiency=ETA, efficiency_back=back
        ),
        "brushes": coulomb("motor", brushes),
        "bearing": coulomb("wheel", BEARING),
    }
    return mechanism(
        {"motor": rotor(NEAR), "wheel": rotor(FAR)}, links, "motor", "motor", travel=(-100.0, 100.0)
    )


def _ends(found: Mechanism) -> tuple[float, float]:
    one = chain(found, None).one.scalars()
    return one["inertia.least"], one["inertia.most"]


def test_the_interval_is_that_of_both_efficiencies() -> None:
    assert _ends(geared()) == pytest.approx(
        (NEAR + RATIO**2 * FAR * ETA_BACK, NEAR + RATIO**2 * FAR / ETA), rel=1e-12
    )
    assert chain(geared(), None).one.inertia == pytest.approx(NEAR + RATIO**2 * FAR, rel=1e-12)


def test_two_links_in_a_chain_multiply() -> None:
    whole = geared()
    second = Gear(("wheel", "drum"), 0.5, internal=True, efficiency=0.9, efficiency_back=0.85)
    longer = msgspec.structs.replace(
        whole, blocks={**whole.blocks, "drum": rotor(0.04)}, links={**whole.links, "second": second}
    )
    wheel, drum = RATIO**2 * FAR, (0.5 * RATIO) ** 2 * 0.04
    least, most = NEAR + ETA_BACK * (wheel + 0.85 * drum), NEAR + (wheel + drum / 0.9) / ETA
    assert _ends(longer) == pytest.approx((least, most), rel=1e-12)


def test_what_an_irreversible_link_holds_back_is_less_than_the_motor_alone() -> None:
    assert _ends(geared(back=-0.4)) == pytest.approx(
        (NEAR - 0.4 * RATIO**2 * FAR, NEAR + RATIO**2 * FAR / ETA), rel=1e-12
    )
    assert _ends(geared(back=-0.9))[0] == pytest.approx(
        NEAR, rel=1e-12
    )  # it would be below 0: it locks


def test_a_weight_that_is_lowered_through_a_worm_shows_the_lower_end_and_lifted_the_upper() -> None:
    back, weight, count, period = -0.2, 2.0, 100, 1e-3
    one = geared(back=back)
    whole = msgspec.structs.replace(
        one,
        sources={
            **one.sources,
            "weight": Source("wheel", "effort", effort=Quantity(-weight, unit="N m")),
        },
        control=Control("motor", "encoder"),
    )
    least, most = _ends(whole)
    lowered = BRUSHES - back * RATIO * (
        weight - BEARING
    )  # by hand: what it takes at a steady speed
    lifted = BRUSHES + RATIO * (weight + BEARING) / ETA
    for command, resists, inertia in (
        (-2.5, lowered, least),
        (10.0, lifted, most),
    ):  # not as fast as the weight falls
        way = mechanism_positions(
            from_reference(whole, "motor"), "motor", "encoder", 0.0, np.full(count, command)
        )
        time = period * (len(way) - 1)
        shown = (CONSTANT * abs(command) - resists) * 0.5 * time**2 / abs(way[-1] - way[0])
        assert shown == pytest.approx(inertia, rel=1e-6)
    assert least == pytest.approx(NEAR + back * RATIO**2 * FAR, rel=1e-12)


def test_accelerating_the_whole_mechanism_has_the_upper_end() -> None:
    whole, period, count, current = geared(), 1e-3, 200, 4.0
    way = mechanism_positions(
        from_reference(whole, "motor"), "motor", "encoder", 0.0, np.full(count, current)
    )
    friction = BRUSHES + RATIO * BEARING / ETA
    time = period * (len(way) - 1)
    shown = 0.5 * (CONSTANT * current - friction) * time**2 / (way[-1] - way[0])
    assert whole.sample_period_s == period
    assert shown == pytest.approx(_ends(whole)[1], rel=1e-6)


def test_coasting_against_strong_brushes_it_is_within_and_below_the_value() -> None:
    whole, period = geared(brushes=0.1), 1e-3
    push = 200
    way = mechanism_positions(
        from_reference(whole, "motor"),
        "motor",
        "encoder",
        0.0,
        np.concatenate([np.full(push, 4.0), np.zeros(60)]),
    )
    later = way[push + 5 : push + 45]
    slowing = -float(np.mean(np.diff(later, 2))) / period**2
    friction = chain(whole, None).one.forward.curve[0]
    shown = friction / slowing
    least, _ = _ends(whole)
    # by hand: the wheel pushes the gear back with m a - C, of which the motor feels eta_back
    by_hand = NEAR + ETA_BACK * RATIO**2 * FAR
    assert slowing == pytest.approx((0.1 + RATIO * BEARING * ETA_BACK) / by_hand, rel=1e-6)
    assert least <= shown < chain(whole, None).one.inertia


def test_a_link_turned_round_that_nothing_can_drive_is_refused() -> None:
    whole = geared()
    worm = Gear(
        ("wheel", "motor"), 1.0 / RATIO, internal=True, efficiency=0.4, efficiency_back=-0.2
    )
    with pytest.raises(NoSolutionError, match="swap the two blocks of the link"):
        chain(msgspec.structs.replace(whole, links={**whole.links, "gear": worm}), None)

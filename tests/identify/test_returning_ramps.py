"""Breakaway ramps between which a load moves the axis back to its rest position."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.documents.bench import Bench
from frictool.documents.load_terms import LoadTerms, RipplePeriod, Term
from frictool.documents.quantity import Quantity
from frictool.errors import NoSolutionError
from frictool.identify.breakaway.onset_detection import passages_of, returning_share
from frictool.identify.breakaway.position_law import COUNTS_PER_TERM, HIGHEST_ORDER, highest_order
from frictool.identify.excite.breakaway_ramps import (
    breakaway_range,
    may_move_freely,
    never_at_rest,
    returning_ramps,
)
from frictool.identify.excite.excitation_kinds import ExcitationSettings, excite
from frictool.identify.excite.precise_ramps import precise_ramps
from frictool.identify.excite.precise_strokes import PrecisionRequest
from frictool.identify.identification import NothingIdentified, identify_records
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord, make_record
from studies.rigs.identification_rigs import mass_bench
from tests.identify.arm import PERIOD

STEP = 1e-4  # m


def ramps(load: float, breakaway: float, driven: bool = False, count: int = 8) -> MotionRecord:
    """Return ramps of a mass of 1 kg with a breakaway [N], pressed to 0 by a preload [N].

    The drive falls to 0 after an advance of 10 mm. The mass then moves back if the preload exceeds
    the breakaway, or if the drive is reversed (`driven`).
    """
    x = v = 0.0
    position, effort = [], []
    for _ in range(count):
        u = 0.0
        start = x
        for _ in range(400):
            position.append(x)
            effort.append(0.0)
        while x - start < 0.01:
            u += 0.02
            net = u - load - breakaway
            v = max(v + PERIOD * net, 0.0) if net > 0.0 or v > 0.0 else 0.0
            x += PERIOD * v
            position.append(x)
            effort.append(u)
        for _ in range(600):
            u = -1.5 * breakaway if driven and x > start else 0.0
            net = u - load
            if v > 0.0:
                v = max(v + PERIOD * (net - breakaway), 0.0)
            elif x > start and -net > breakaway:
                v += PERIOD * (net + breakaway)
            x = max(x + PERIOD * v, start if v < 0.0 else x)
            v = 0.0 if x == start else v
            position.append(x)
            effort.append(u)
    seen = np.floor(np.array(position) / STEP) * STEP
    time = PERIOD * np.arange(seen.size)
    return make_record("ramps", time, seen, np.array(effort), STEP, 0.0)


@pytest.mark.parametrize(
    ("load", "driven", "share"), [(9.0, False, 1.0), (0.0, False, 0.0), (0.0, True, 0.0)]
)
def test_only_a_load_moves_the_axis_back_without_drive(
    tmp_path: Path, load: float, driven: bool, share: float
) -> None:
    """A mass that rests, or that the drive returns, has no load above its breakaway."""
    assert returning_share(ramps(load, 6.0, driven), mass_bench(tmp_path)) == share


def test_the_breakaway_of_returning_ramps_is_refused(tmp_path: Path) -> None:
    """Without a log of sliding, the load at the rest position is unknown."""
    record = ramps(9.0, 6.0)
    with pytest.raises(NothingIdentified) as error:
        identify_records([], [record], mass_bench(tmp_path), "auto", IdentificationSettings())
    reason = error.value.result.refused["breakaway"]
    assert "the axis returns to" in reason
    assert len(f"not identified: breakaway: {reason}") <= 210


def test_passages_count_motions_through_a_position_only() -> None:
    """Flicker at the position, and motion on one side, are no passage."""
    x = np.concatenate((np.tile([0.0, STEP], 20), np.linspace(0.0, 0.1, 200)))
    time = PERIOD * np.arange(4 * x.size)
    there = np.concatenate((x, x[::-1], x, x[::-1]))
    record = make_record("log", time, there, 0.0 * there, STEP, 0.0)
    assert passages_of(record, 0.0) == 0
    assert passages_of(record, 0.05) == 4


def test_an_order_needs_counts() -> None:
    """Onsets within a few counts show no friction over the position."""
    assert highest_order(5.0) == 0
    assert highest_order(2.0 * COUNTS_PER_TERM) == 1
    assert highest_order(1e6) == HIGHEST_ORDER


def test_ramps_warn_of_a_load_above_the_breakaway(tmp_path: Path) -> None:
    """The offset's range decides; a small offset lets the axis rest wherever a ramp ends."""
    bench = mass_bench(tmp_path)
    least = returning_bench(bench, 1e-3)
    assert returning_ramps(least) is None
    warning = returning_ramps(returning_bench(bench, 1.2 * bench.mechanics.coulomb.value))
    assert warning is not None
    assert "exceed the breakaway" in warning
    assert len(f"warning: {warning}") <= 190


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_weight_above_the_breakaway_allows_no_ramps(tmp_path: Path, sign: float) -> None:
    """The drive is 0 between the ramps: the weight, of either sign, would then accelerate."""
    bench = mass_bench(tmp_path)
    most = breakaway_range(bench)[2]
    for factor, possible in ((0.9, True), (1.1, False)):
        offset = Quantity(sign * factor * most, unit="N")
        weight = msgspec.structs.replace(
            bench, mechanics=msgspec.structs.replace(bench.mechanics, offset=offset)
        )
        assert (never_at_rest(weight) is None) is possible
    with pytest.raises(NoSolutionError, match="this load moves the axis"):
        precise_ramps(weight, PrecisionRequest({"breakaway": 0.1}))
    with pytest.raises(NoSolutionError, match="this load moves the axis") as error:
        excite("breakaway", weight, ExcitationSettings())
    assert len(f"error: {error.value}") <= 190


def test_a_load_over_position_of_unknown_size_allows_no_ramps(tmp_path: Path) -> None:
    """The load moves the axis never below the least breakaway, and always above the largest."""
    bench = mass_bench(tmp_path)
    least, _, most = breakaway_range(bench)
    with pytest.raises(NoSolutionError, match=r"an arm falls\); state load.most") as error:
        excite("breakaway", loaded(bench, "spring", None), ExcitationSettings())
    assert len(f"error: {error.value}") <= 190
    small, middle, large = (
        loaded(bench, "spring", one) for one in (0.9 * least, 0.5 * (least + most), 1.1 * most)
    )
    assert never_at_rest(small) is None
    assert not may_move_freely(small)
    assert never_at_rest(middle) is None
    assert may_move_freely(middle)
    assert "load.most: at least" in (never_at_rest(large) or "")


def test_a_ripple_moves_the_axis_within_a_period_only(tmp_path: Path) -> None:
    assert never_at_rest(loaded(mass_bench(tmp_path), "ripple", None)) is None


def loaded(bench: Bench, term: Term, most: float | None) -> Bench:
    ripple = RipplePeriod(1.0, Quantity(0.1, unit="m")) if term == "ripple" else None
    size = None if most is None else Quantity(most, unit="N")
    return msgspec.structs.replace(bench, load=LoadTerms(("offset", term), ripple, size))


def returning_bench(bench: Bench, offset: float) -> Bench:
    """Return the bench with an offset of 0 to `offset` [N]."""
    known = Quantity(0.5 * offset, 0.0, offset, "N")
    return msgspec.structs.replace(
        bench, mechanics=msgspec.structs.replace(bench.mechanics, offset=known)
    )

"""Presliding from slow loops: the virgin curve of the Masing hysteresis comes back, and what an encoder does not resolve is refused."""

from __future__ import annotations

import numpy as np
import pytest

from frictool.friction.preisach_cycles import masing_everett
from frictool.friction.virgin_curve import virgin_force
from frictool.identify.outcome import NothingUsable
from frictool.identify.presliding import preisach_table, presliding
from frictool.identify.record import Record, make_record

F_S, Z_MAX, STEPS = 1.5, 1e-5, 400


def loops(turns: list[float], count: float, noise: float = 0.0) -> Record:
    """Masing's hysteresis of the parabola through displacements `turns` [z_max], each beyond the one before: no reversal is wiped out."""
    position, force = [np.zeros(1)], [np.zeros(1)]
    start, level = 0.0, 0.0
    for number, turn in enumerate(turns):
        z = np.linspace(start, turn, STEPS)
        scale = 1.0 if number == 0 else 2.0
        f = level + np.array([scale * virgin_force((point - start) * Z_MAX / scale, F_S, Z_MAX) for point in z])
        position.append(z * Z_MAX)
        force.append(f)
        start, level = turn, f[-1]
    x, u = np.concatenate(position), np.concatenate(force)
    u = u + noise * np.random.default_rng(1).standard_normal(u.size)
    return make_record("loops", np.arange(x.size) * 1e-3, np.floor(x / count) * count, u, count, 0.0)


def test_the_virgin_curve_comes_back() -> None:
    found = presliding(loops([0.8, -0.85, 0.9, -0.95, 1.0], 1e-8, noise=0.002), F_S, 1.0)
    exact = [virgin_force(z, F_S, Z_MAX) for z in found.displacement]
    assert found.force == pytest.approx(exact, abs=0.03 * F_S)
    assert found.limit == pytest.approx(Z_MAX, rel=0.1)
    assert found.stiffness == pytest.approx(2.0 * F_S / Z_MAX, rel=0.1)  # the parabola's slope at 0
    assert np.all(np.diff(found.force, prepend=0.0) >= 0.0)
    assert found.maxwell.size == 2 * found.displacement.size
    assert 0.0 < found.elastic_limit < found.limit


def test_z_max_from_loops_that_stay_below_it() -> None:
    assert presliding(loops([0.6, -0.6, 0.6, -0.6], 1e-8), F_S, 1.0).limit == pytest.approx(Z_MAX, rel=0.1)


def test_a_coarse_encoder_is_refused_with_the_count_that_would_do() -> None:
    with pytest.raises(NothingUsable, match=r"counts of the encoder; a count of .* or less would resolve it"):
        presliding(loops([0.8, -0.85, 0.9, -0.95, 1.0], 2.5e-6), F_S, 1.0)
    with pytest.raises(NothingUsable, match="sees no motion below the breakaway"):
        presliding(loops([0.8, -0.85, 0.9], 1e-3), F_S, 1.0)


def test_small_loops_are_refused() -> None:
    with pytest.raises(NothingUsable, match="of the breakaway; at least 50 % are needed"):
        presliding(loops([0.1, -0.1, 0.1], 1e-8), F_S, 1.0)


def test_preisach_of_centred_cycles_is_masing_s() -> None:
    """Ten cycles of growing amplitude: the table of 3.7.1."""
    position, force, last = [0.0], [0.0], 0.0
    for top in np.arange(1, 11) / 10.0:
        reach, fall = virgin_force(top * Z_MAX, F_S, Z_MAX), np.linspace(top, -top, STEPS)
        position += [*np.linspace(last, top, STEPS)[1:-1], *fall]
        force += [
            *np.linspace(force[-1], reach, STEPS)[1:-1],
            *(reach + 2.0 * virgin_force(0.5 * (z - top) * Z_MAX, F_S, Z_MAX) for z in fall),
        ]
        last = -top
    x = np.array(position) * Z_MAX
    record = make_record("cycles", np.arange(x.size) * 1e-3, np.rint(x / 1e-9) * 1e-9, np.array(force), 1e-9, 0.0)
    assert preisach_table(record, 10) == pytest.approx(masing_everett(), abs=5e-3)
    with pytest.raises(NothingUsable, match="no centred cycle of amplitude"):
        preisach_table(record, 7)

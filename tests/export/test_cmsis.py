"""CMSIS-DSP arrays against our own plain implementation of the recursion that its documentation
states, in floats and in whole numbers."""

from __future__ import annotations

import math
import re
import subprocess
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st
from scipy import signal

from frictool.documents.controller import Controller, Number
from frictool.errors import NoSolutionError
from frictool.export.biquads import Biquads, fixed_biquads, float_biquads, response_sum
from frictool.export.cmsis import cmsis_arrays, cmsis_header
from frictool.export.controller_export import export
from frictool.typing import Vector
from studies.rigs.example_controllers import clutch_controller
from studies.rigs.verified_controller import truthful
from tests.support.compiled_c import COMPILERS, ORIGIN, STRICT, needs_compiler
from tests.support.export_controllers import scheduled

BITS = {"q31": 31, "q15": 15}
ENTERING = 3.0
poles = st.tuples(st.floats(0.0, 0.97), st.floats(0.0, math.pi))
numerators = st.tuples(*[st.floats(-4.0, 4.0)] * 3).filter(lambda row: max(map(abs, row)) > 0.1)


@st.composite
def chains(draw: st.DrawFn) -> tuple[tuple[float, ...], ...]:
    """One to four stable sections b0 b1 b2 a0 a1 a2."""
    rows = []
    for _ in range(draw(st.integers(1, 4))):
        radius, angle = draw(poles)
        rows.append((*draw(numerators), 1.0, -2.0 * radius * math.cos(angle), radius * radius))
    return tuple(rows)


def plain_float(stages: tuple[tuple[float, ...], ...], x: Vector) -> Vector:
    """arm_biquad_cascade_df1_f32 as documented: y = b0 x + b1 x1 + b2 x2 + a1 y1 + a2 y2, stage by
    stage, in double."""
    for b0, b1, b2, a1, a2 in stages:
        y = np.zeros(len(x))
        for n in range(len(x)):
            x1, y1 = (x[n - 1], y[n - 1]) if n > 0 else (0.0, 0.0)
            x2, y2 = (x[n - 2], y[n - 2]) if n > 1 else (0.0, 0.0)
            y[n] = b0 * x[n] + b1 * x1 + b2 * x2 + a1 * y1 + a2 * y2
        x = y
    return x


def plain_words(made: Biquads, number: Number, x: list[int]) -> list[int]:
    """arm_biquad_cascade_df1_q31 and _q15 as documented, in whole numbers; asserts that q31 never
    wraps and q15 never saturates."""
    bits = BITS[number]
    for b0, b1, b2, a1, a2 in made.stages:
        x1 = x2 = y1 = y2 = 0
        left = []
        for now in x:
            total = b0 * now + b1 * x1 + b2 * x2 + a1 * y1 + a2 * y2
            assert number == "q15" or abs(total) < 2**63
            shifted = total >> (bits - made.post_shift)
            assert -(2**bits) <= shifted < 2**bits
            x1, x2, y1, y2 = now, x1, shifted, y1
            left.append(shifted)
        x = left
    return x


def filtered(sections: tuple[tuple[float, ...], ...], x: Vector) -> Vector:
    return np.asarray(signal.sosfilt(np.array(sections), x))


@given(chains(), st.integers(0, 2**16))
def test_float_arrays_are_the_sections_with_the_sign_of_a_changed(
    chain: tuple[tuple[float, ...], ...], seed: int
) -> None:
    x = np.random.default_rng(seed).uniform(-1.0, 1.0, 120)
    made = float_biquads(chain)
    assert all(float(np.float32(value)) == value for stage in made.stages for value in stage)
    exact = filtered(chain, x)
    assert np.max(np.abs(plain_float(made.stages, x) - exact)) <= 1e-3 * response_sum(chain)
    np.testing.assert_allclose(
        plain_float(made.stages, x),
        filtered(made.sections("float"), x),
        atol=1e-9 * response_sum(chain),
    )


@pytest.mark.parametrize("number", ["q31", "q15"])
@settings(max_examples=15)
@given(chain=chains(), seed=st.integers(0, 2**16))
def test_fixed_arrays_never_wrap_and_stay_within_the_stated_noise(
    number: Number, chain: tuple[tuple[float, ...], ...], seed: int
) -> None:
    """Against the sections with the coefficients as they are kept; the input is the worst one for
    the last sample, and random."""
    try:
        made = fixed_biquads("c", chain, number, ENTERING)
    except NoSolutionError:  # poles near the circle, or stages so unlike that no bound exists
        reject()
    _never_wraps(made, chain, number, seed)


def _never_wraps(
    made: Biquads, chain: tuple[tuple[float, ...], ...], number: Number, seed: int
) -> None:
    bits, kept = BITS[number], made.sections(number)
    impulse = filtered(kept, np.eye(1, 300)[0])
    worst = ENTERING * np.sign(impulse[::-1])
    for x in (worst, np.random.default_rng(seed).uniform(-ENTERING, ENTERING, 200)):
        words = [round(math.ldexp(value / made.input_scale, bits)) for value in x]
        drives = (
            np.ldexp(np.array(plain_words(made, number, words), dtype=np.float64), -bits)
            * made.output_scale
        )
        exact = filtered(kept, x)
        assert np.max(np.abs(drives - exact)) <= made.noise * (1.0 + 1e-6) + 1e-9 * response_sum(
            kept
        )
    if number == "q31":
        assert np.max(np.abs(exact - filtered(chain, x))) <= 1e-4 * ENTERING * response_sum(chain)


def test_an_integrator_is_refused_in_fixed_point_and_kept_in_float() -> None:
    chain = ((1.0, 0.5, 0.0, 1.0, -1.0, 0.0),)
    with pytest.raises(NoSolutionError, match=r"a pole on or outside the unit circle"):
        fixed_biquads("c", chain, "q31", ENTERING)
    assert float_biquads(chain).stages == ((1.0, 0.5, 0.0, 1.0, 0.0),)


def test_scheduled_coefficients_are_no_arrays() -> None:
    with pytest.raises(NoSolutionError, match="scheduled coefficients"):
        cmsis_arrays(scheduled(truthful(clutch_controller())), "float")


@pytest.fixture(scope="module")
def controller() -> Controller:
    return truthful(clutch_controller())


def test_there_are_no_biquads_in_double(controller: Controller) -> None:
    with pytest.raises(
        NoSolutionError, match="have no double format; use --number float, q31 or q15"
    ):
        export(controller, "cmsis", "double", ORIGIN)


@needs_compiler
@pytest.mark.parametrize("number", ["float", "q31", "q15"])
def test_header_compiles_and_holds_the_arrays(
    controller: Controller, number: Number, tmp_path: Path
) -> None:
    arrays = cmsis_arrays(controller, number)
    (name, text), *others = cmsis_header(controller, number, arrays, 0.6, ORIGIN).items()
    assert (name, others) == ("speed_cmsis.h", [])
    (tmp_path / name).write_text(text)
    printed = "%.9g" if number == "float" else "%ld"
    cast = "(double)" if number == "float" else "(long)"
    main = f'#include <stdio.h>\n#include "{name}"\nint main(void)\n{{\n    unsigned k;\n\n'
    main += "    for (k = 0; k < sizeof speed_coefficients / sizeof speed_coefficients[0]; k++) {\n"
    main += (
        f'        printf("{printed}\\n", {cast}speed_coefficients[k]);\n    }}\n    return 0;\n}}\n'
    )
    (tmp_path / "main.c").write_text(main)
    subprocess.run(
        [COMPILERS[0], *STRICT, str(tmp_path / "main.c"), "-o", str(tmp_path / "main")],
        check=True,
        capture_output=True,
    )
    told = subprocess.run(
        [tmp_path / "main"], check=True, capture_output=True, text=True
    ).stdout.split()
    width = 6 if number == "q15" else 5
    rows = [told[k : k + width] for k in range(0, len(told), width)]
    if number == "q15":  # 0 between b0 and b1
        assert {row.pop(1) for row in rows} == {"0"}
    np.testing.assert_array_equal(
        np.array(rows, dtype=np.float32), np.array(arrays.biquads.stages, dtype=np.float32)
    )
    assert re.search(
        r"order +" + ("b0 0 b1 b2 a1 a2" if number == "q15" else "b0 b1 b2 a1 a2"), text
    )
    assert "a1 and a2 are added" in text
    assert ORIGIN.sha256 in text


def test_q15_words_fit_16_bits(controller: Controller) -> None:
    arrays = cmsis_arrays(controller, "q15")
    assert all(-(2**15) <= word < 2**15 for stage in arrays.biquads.stages for word in stage)
    assert msgspec.structs.asdict(arrays.linear)["form"] == "sos"

"""Fixed point: no value ever leaves the interval that is proved for it, the header says what runs,
and counts become words."""

from __future__ import annotations

import math
import re
from collections import Counter
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.adapters.controller_composition import controller_program
from frictool.control.coefficient_words import BITS
from frictool.control.compiled_program import compile_program, control_step, read, start_at
from frictool.control.fixed_point import fixed_program
from frictool.control.number_format import machine_in
from frictool.documents.controller import Controller, ProgramNumber
from frictool.export.fixed_point_header import multiplier
from frictool.export.golden_vectors import golden_vectors
from tests.support.compiled_c import (
    COMPILERS,
    built,
    fits,
    library,
    needs_compiler,
    ran,
    simulated,
    sources,
    write,
)
from tests.support.export_cases import CASES
from tests.support.export_controllers import controllers
from tests.support.export_inputs import rows_for

fixed = st.sampled_from(["q31"])


def test_no_word_leaves_its_proved_interval() -> None:
    fitting: Counter[str] = Counter()

    @settings(max_examples=25)
    @given(controllers(), fixed, st.integers(0, 2**16))
    def check(controller: Controller, number: ProgramNumber, seed: int) -> None:
        if fits(controller_program(controller), number):
            fitting[number] += 1
            _words_stay_within(controller, number, seed)

    check()
    assert fitting["q31"] >= 5


def _words_stay_within(controller: Controller, number: ProgramNumber, seed: int) -> None:
    program = controller_program(controller)
    scaled, running = fixed_program(program, BITS[number]), machine_in(program, number)
    low, high = (
        np.array([scaled.words[node.index][end] for node in program.nodes]) for end in (0, 1)
    )
    rows = 3.0 * rows_for(controller, program, 150, seed)  # beyond the travel, too: inputs saturate
    start_at(running, rows[0, 1])
    for row in rows:
        control_step(running, row[0], row[1], row[2] if len(program.inputs) > 2 else 0.0)
        words = running.word[: len(program.nodes)]
        assert np.all((low <= words) & (words <= high))
    assert max(-low.min(), high.max()) < 2**31
    assert scaled.longest < 2**63


@pytest.mark.parametrize("number", ["q31"])
def test_every_word_is_near_the_value_in_double_while_no_limit_is_met(
    number: ProgramNumber,
) -> None:
    """One sample from rest: each value of the program within what its fraction resolves, times what
    operations behind amplify."""
    program = controller_program(CASES["cut"])
    running, double = machine_in(program, number), compile_program(program)
    for one in (running, double):
        start_at(one, 20.0)
        control_step(one, 21.0, 20.0, 0.0)
    for node in program.nodes:
        found, exact = read(running, node.index), read(double, node.index)
        assert found == pytest.approx(exact, rel=2.0 ** -(BITS[number] - 4), abs=2e-4)


@pytest.mark.parametrize("number", ["q31"])
def test_drive_limit_of_the_header_is_the_largest_word_of_the_drive(number: ProgramNumber) -> None:
    """A limit that no word holds exactly."""
    made = msgspec.structs.replace(CASES["cut"], drive_limit=0.7)
    program = controller_program(made)
    vectors = golden_vectors(made, program, number)
    assert program.output is not None
    largest = math.ldexp(
        max(row[-1] for row in vectors.rows),
        fixed_program(program, BITS[number]).fractions[program.output.index],
    )
    assert (
        f"#define SPEED_DRIVE_LIMIT {int(largest)}\n" in sources(made, number, vectors)["speed.h"]
    )


@pytest.mark.parametrize("case", ["cut", "cascade", "position", "sections"])
@pytest.mark.parametrize("number", ["q31"])
def test_header_states_fractions_ranges_and_the_proof(case: str, number: ProgramNumber) -> None:
    program = controller_program(CASES[case])
    scaled, header = fixed_program(program, BITS[number]), sources(CASES[case], number)["speed.h"]
    assert program.output is not None
    for name, node in [*program.inputs.items(), ("drive", program.output)]:
        low, high = scaled.words[node.index]
        assert f"#define SPEED_{name.upper()}_FRACTION {scaled.fractions[node.index]}\n" in header
        assert (
            f"#define SPEED_{name.upper()}_LOW ({low})\n#define SPEED_{name.upper()}_HIGH "
            f"({high})\n" in header
        )
    assert f"is {scaled.longest} < 2^{scaled.longest.bit_length()} (limit: 2^63)" in header
    proved = re.findall(
        r"^ \* (\S+(?: \(\w+\))?) +(-?\d+) +(-?\d+) to (-?\d+)  ", header, flags=re.MULTILINE
    )
    told = {name: (int(fraction), int(low), int(high)) for name, fraction, low, high in proved}
    states = {
        name: (scaled.fractions[node.index], *scaled.words[node.index])
        for name, node in program.states.items()
    }
    assert states.items() <= told.items()
    limit = math.ldexp(50.0, scaled.fractions[program.output.index])
    assert f"#define SPEED_DRIVE_LIMIT {round(limit)}\n" in header
    assert told[program.names[program.output.index]] == (
        scaled.fractions[program.output.index],
        -round(limit),
        round(limit),
    )


MACROS = """
#include <stdio.h>
#include "speed.h"

int main(void)
{
    int32_t counts;

    for (counts = -280; counts <= 840; counts += 7) {
        printf("%ld %ld ", (long)counts, (long)SPEED_POSITION_FROM_COUNTS(counts));
    }
    printf("\\n%ld %ld %ld", (long)SPEED_REFERENCE(-12.3), (long)SPEED_POSITION(45.6),
        (long)SPEED_DRIVE_IN_THOUSANDTHS(-SPEED_DRIVE_LIMIT));
    return 0;
}
"""


@needs_compiler
@pytest.mark.parametrize("number", ["q31"])
def test_macros_of_the_header(number: ProgramNumber, tmp_path: Path) -> None:
    """Compiled as strictly as the rest: counts, constants, and the drive in thousandths."""
    program = controller_program(CASES["cut"])
    fraction = fixed_program(program, BITS[number]).fractions[program.inputs["position"].index]
    write(CASES["cut"], tmp_path, number)
    (tmp_path / "speed_selftest.c").write_text(MACROS)
    code, told, _ = ran(built(tmp_path, COMPILERS[-1]))
    counted, others = told.split("\n")
    pairs = np.array(counted.split(), dtype=np.int64).reshape(-1, 2)
    step = CASES["cut"].bench.encoder.resolution
    assert code == 0
    assert np.max(np.abs(pairs[:, 1] - pairs[:, 0] * step * 2.0**fraction)) <= 1.0
    assert others.split() == [
        str(round(-12.3 * 2**fraction)),
        str(round(45.6 * 2**fraction)),
        "-50000",
    ]


@needs_compiler
@pytest.mark.parametrize("case", ["cascade", "position"])
@pytest.mark.parametrize("number", ["q31"])
def test_any_words_at_all_are_saturated_and_never_undefined(
    case: str, number: ProgramNumber, tmp_path: Path
) -> None:
    """Inputs over the whole of int32_t, its ends among them, under the sanitizer."""
    program, random = controller_program(CASES[case]), np.random.default_rng(3)
    rows = random.integers(1 - 2**31, 2**31, (3000, len(program.inputs))).astype(np.int32)
    rows[1000:] = np.where(random.random((2000, len(program.inputs))) < 0.5, 1 - 2**31, 2**31 - 1)
    rows[2000:, 1][random.random(1000) < 0.3] = -(
        2**31
    )  # the word that stands for no number: some in a row, and the fault in the end
    write(CASES[case], tmp_path, number)
    play = library(
        CASES[case],
        number,
        tmp_path,
        COMPILERS[0],
        "-O1",
        "-fsanitize=undefined",
        "-fno-sanitize-recover=all",
    )
    assert play(rows).tobytes() == simulated(program, number, rows).tobytes()


@given(st.floats(1e-7, 10.0), st.integers(0, 40), st.integers(-(2**30), 2**30))
def test_counts_become_words_to_the_nearest_but_for_the_multiplier(
    step: float, fraction: int, counts: int
) -> None:
    """POSITION_FROM_COUNTS, computed in whole numbers, is exact within half a word and the rounding
    of the step to 31 bits."""
    m, n = multiplier(step, fraction)
    word = counts * step * 2.0**fraction
    if not abs(word) < 2**31:
        return
    product = counts * m
    found = (abs(product) + (1 << n >> 1) >> n) * (1 if product >= 0 else -1)
    assert abs(product) + (1 << n >> 1) < 2**63
    assert abs(found - word) <= 0.5 + abs(counts) * 2.0**-n + 2.0**-20

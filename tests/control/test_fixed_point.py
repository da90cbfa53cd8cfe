"""Fixed point: equal to whole numbers without bounds, never outside what is proved, near double,
and refused where nothing is bounded."""

from __future__ import annotations

import math
from collections.abc import Callable

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.adapters.controller_composition import controller_program
from frictool.control.coefficient_words import BITS, coefficient, round_coefficient
from frictool.control.compiled_program import (
    PORTS,
    CompiledProgram,
    compile_program,
    control_step,
    copy_program,
    start_at,
)
from frictool.control.fixed_point import FixedPointOverflow, fixed_machine, fixed_program
from frictool.control.program import Program, ProgramNode
from frictool.documents.controller import Controller, LinearController, Velocity
from studies.rigs.example_controllers import (
    BRAKE_LAW,
    CUT_LAW,
    closed_loop_inputs,
    clutch_controller,
    emps_controller,
)
from tests.control.programs import hostile, random_program
from tests.control.random_controllers import Sample, assaults, controllers, seeds, space, wanderings
from tests.support.interpreted_program import InWords

bits = st.sampled_from(sorted(BITS.values()))


def _equal(made: CompiledProgram, plain: InWords, samples: list[dict[str, float]]) -> None:
    """Every value and state, word by word; the plain one raises where a value is not where it was
    proved to be."""
    program = plain.program
    computed = [node.index for node in program.nodes if node.index not in plain.states]
    for row in samples:
        drive = control_step(made, *[row.get(name, 0.0) for name in PORTS])
        assert drive == plain.step(row)
        assert made.word[computed].tolist() == [plain.values[place] for place in computed]
        assert made.word[list(plain.states)].tolist() == list(plain.states.values())


@settings(max_examples=2 * settings.default.max_examples)
@given(seeds, bits)
def test_no_program_overflows(seed: int, kept: int) -> None:
    """Any program with any inputs: all that is computed stays within its proved interval, its word
    and 64 bits."""
    program = random_program(seed)
    try:
        scaled = fixed_program(program, kept)
    except FixedPointOverflow:
        return
    made, plain = fixed_machine(scaled), InWords(scaled, 1e3)
    start_at(made, 1e3)
    _equal(made, plain, hostile(seed, program, 20))


def test_most_random_programs_fit() -> None:
    """test_no_program_overflows leaves out the smaller part."""

    def fits(seed: int) -> bool:
        try:
            return bool(fixed_program(random_program(seed), 31))
        except FixedPointOverflow:
            return False

    assert sum(fits(seed) for seed in range(100)) >= 60


@given(controllers(bounded=True, scheduled=False), assaults(40) | wanderings(20), bits)
def test_no_controller_overflows(
    controller: Controller, sequence: tuple[float, list[Sample]], kept: int
) -> None:
    """References and positions that jump from end to end and beyond at every sample: no value
    leaves its proved interval."""
    start, samples = sequence
    try:
        scaled = fixed_program(controller_program(controller), kept)
    except FixedPointOverflow:
        return
    made, plain = fixed_machine(scaled), InWords(scaled, start)
    start_at(made, start)
    _equal(made, plain, [dict(zip(PORTS, sample, strict=True)) for sample in samples])


DESIGNS = {
    "clutch, cut": (clutch_controller(CUT_LAW), 5.0, 55.0),
    "clutch, brake": (clutch_controller(BRAKE_LAW), 5.0, 55.0),
    "EMPS": (emps_controller(), 0.0, 0.2),
}


@pytest.mark.parametrize("kept", BITS.values(), ids=BITS)
@pytest.mark.parametrize("design", DESIGNS)
def test_an_ordinary_run_meets_no_bound(design: str, kept: int) -> None:
    """Steps there and back in closed loop: no state saturates at the bound that its block states,
    and inputs stay inside theirs."""
    controller, start, target = DESIGNS[design]
    scaled = fixed_program(controller_program(controller), kept)
    plain = InWords(scaled, start)
    inputs = closed_loop_inputs(controller, start, target)
    for row in inputs:
        plain.step(row)
    assert plain.saturated == set()
    for name in ("reference", "position"):
        node = plain.program.inputs[name]
        assert (
            node.low
            < min(row[name] for row in inputs)
            <= max(row[name] for row in inputs)
            < node.high
        )


# of the drive's limit; measured 1.5e-6 and 5.7e-5: the carriage's gain over its travel is 35 times
# the clutch's, in drive limits
BOUNDS = {"clutch, cut": 1e-5, "clutch, brake": 1e-5, "EMPS": 1e-4}


@pytest.mark.parametrize("number", BITS)
@pytest.mark.parametrize("design", DESIGNS)
def test_fixed_point_is_near_double_over_a_step(design: str, number: str) -> None:
    """Double with the coefficients that the format keeps, and the same inputs: what the words alone
    do. q31 is near the unrounded one, too.

    What the rounded coefficients do to the loop is verified before export (verify/rounding.py).
    """
    controller, start, target = DESIGNS[design]
    program = controller_program(controller)
    double, words = compile_program(program), fixed_machine(fixed_program(program, BITS[number]))
    exact = copy_program(double)
    for node in program.nodes:
        if node.op == "constant" and node.index in program.names:
            double.real[node.index] = round_coefficient(node.value, BITS[number])
    rows = [
        (row["reference"], row["position"], 0.0)
        for row in closed_loop_inputs(controller, start, target)
    ]
    for made in (double, words, exact):
        start_at(made, start)
    of_double, of_words, of_exact = (
        np.array([control_step(made, *row) for row in rows]) for made in (double, words, exact)
    )
    assert np.max(np.abs(of_double)) > 0.02 * controller.drive_limit
    assert np.max(np.abs(of_words - of_double)) <= BOUNDS[design] * controller.drive_limit
    np.testing.assert_array_equal(
        of_words == 0.0, of_double == 0.0
    )  # rest is exactly zero in both, at the same samples
    if number == "q31":
        assert np.max(np.abs(of_words - of_exact)) <= BOUNDS[design] * controller.drive_limit


@given(st.floats(-1e12, 1e12).filter(lambda value: abs(value) > 1e-12 or value == 0.0), bits)
def test_a_coefficient_keeps_its_bits(value: float, kept: int) -> None:
    word, fraction = coefficient(value, kept)
    assert abs(word) < 2**kept
    assert round_coefficient(value, kept) == math.ldexp(word, -fraction)
    if fraction < 60:
        assert abs(round_coefficient(value, kept) - value) <= 2.0**-kept * abs(value)
    assert round_coefficient(round_coefficient(value, kept), kept) == round_coefficient(value, kept)


@pytest.mark.parametrize("kept", sorted(BITS.values()))
def test_a_coefficient_below_the_finest_fraction_is_zero(kept: int) -> None:
    assert coefficient(1e-300, kept) == (0, 0)
    assert coefficient(-1e-300, kept) == (0, 0)


def _without(controller: Controller, *fields: str) -> Controller:
    return msgspec.structs.replace(
        controller,
        bench=msgspec.structs.replace(
            controller.bench,
            mechanics=msgspec.structs.replace(controller.bench.mechanics, **dict.fromkeys(fields)),
        ),
    )


def _integrating(**options: bool) -> LinearController:
    discrete = space(np.eye(1), np.array([0.01]), np.ones(1), 1.0)
    return LinearController(discrete, discrete, (), (0.0,), **options)


def test_what_has_no_bounds_is_refused_by_name() -> None:
    with pytest.raises(FixedPointOverflow, match="reference has no bounds"):
        fixed_program(controller_program(_without(clutch_controller(), "travel")), 31)
    measured = msgspec.structs.replace(
        clutch_controller(BRAKE_LAW), velocity=Velocity(source="measured")
    )
    assert fixed_program(controller_program(measured), 31)
    with pytest.raises(FixedPointOverflow, match="velocity has no bounds"):
        fixed_program(controller_program(_without(measured, "top_speed")), 31)


def test_an_integrator_that_nothing_holds_is_refused() -> None:
    controller = msgspec.structs.replace(clutch_controller(), linear=_integrating())
    with pytest.raises(FixedPointOverflow, match=r"x\[0\] has no bounds"):
        fixed_program(controller_program(controller), 31)
    held = msgspec.structs.replace(clutch_controller(), linear=_integrating(conditional=True))
    assert fixed_program(controller_program(held), 31)


def _single(build: Callable[[Program, ProgramNode], ProgramNode]) -> Program:
    program = Program()
    program.output = build(program, program.input("position", -1.0, 1.0))
    return program


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (lambda p, x: p.sqrt(x), "is the square root of a value that may be negative"),
        (lambda p, x: x * p.constant(1e30, "huge"), "reaches 1e"),
    ],
)
def test_what_cannot_be_scaled_is_refused(
    build: Callable[[Program, ProgramNode], ProgramNode], words: str
) -> None:
    with pytest.raises(FixedPointOverflow, match=words):
        fixed_program(_single(build), 31)


def test_a_state_far_coarser_than_what_it_becomes_is_refused() -> None:
    """The shift by 64 bits and more that would be needed is none that a word can do."""
    program = Program()
    tiny = program.input("position", -1e-12, 1e-12)
    program.state("coarse", -1e12, 1e12)
    program.update("coarse", tiny)
    program.output = tiny
    with pytest.raises(FixedPointOverflow, match="coarse needs more than 64 bits"):
        fixed_program(program, 31)


@pytest.mark.parametrize(
    "side", [(-(2.0**-58), 0.0), (0.0, 2.0**-58)], ids=["negative", "positive"]
)
def test_a_product_that_rounding_carries_beyond_its_word_is_refused(
    side: tuple[float, float],
) -> None:
    """Near the finest fraction 2^-60 a product of 2.7 rounds to 3, by more than the 2 % of a word
    that are kept free for rounding."""
    program = Program()
    tiny = program.input("position", *side) * program.constant(0.675)
    program.output = tiny * program.constant(1.01 * 2.0 / 3.0 * 2.0**32)
    with pytest.raises(FixedPointOverflow, match=r"value 4 \(mul\) needs more than 32 bits"):
        fixed_program(program, 31)

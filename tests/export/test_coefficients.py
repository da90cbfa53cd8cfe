"""Coefficients for other tools: JSON and MATLAB files hold what runs, say how it is meant, and are
the same every time."""

from __future__ import annotations

import io
import json
import math
from typing import Any

import numpy as np
import pytest
import scipy.io

from frictool.adapters.controller_composition import controller_program
from frictool.control.coefficient_words import BITS
from frictool.control.fixed_point import fixed_program
from frictool.documents.controller import Number
from frictool.export.coefficients import json_files, matlab_files
from frictool.verify.coefficient_rounding import coefficient_rounder
from studies.rigs.example_controllers import BRAKE_LAW, clutch_controller
from tests.support.compiled_c import LOOP, NUMBERS, ORIGIN
from tests.support.export_cases import CASES

CONTROLLER = clutch_controller(BRAKE_LAW)


def content(case: str, number: Number) -> dict[str, Any]:
    ((name, text),) = json_files(CASES[case], number, LOOP, ORIGIN).items()
    assert name == "speed.json"
    found: dict[str, Any] = json.loads(text)
    return found


@pytest.mark.parametrize("number", NUMBERS)
def test_json_holds_the_coefficients_as_the_format_keeps_them(number: Number) -> None:
    found, hold = content("cut", number), coefficient_rounder(number)
    space = CASES["cut"].linear.discrete
    assert found["linear"]["a"] == [[hold(value) for value in row] for row in space.a]
    assert found["linear"]["d"] == hold(space.d[0][0])
    assert (found["format"], found["number"], found["sha256"]) == (
        "coefficients/1",
        number,
        ORIGIN.sha256,
    )
    assert found["program"]["coefficients"]["a"] == found["linear"]["a"]
    assert found["program"]["coefficients"]["law_gain"] == hold(81.1)
    assert "no sign is reversed" in found["conventions"]["a"]


@pytest.mark.parametrize("number", ["q31", "q15"])
def test_words_and_fractions_are_those_of_the_program(number: Number) -> None:
    program, found = controller_program(CASES["cascade"]), content("cascade", number)["program"]
    scaled = fixed_program(program, BITS[number])
    for index, word in scaled.constants.items():
        name = program.names.get(index, "")
        if name and "[" not in name and name in found["words"]:
            assert (found["words"][name], found["fractions"][name]) == (
                word,
                scaled.fractions[index],
            )
            assert found["coefficients"][name] == math.ldexp(word, -scaled.fractions[index])


@pytest.mark.parametrize("case", CASES)
def test_json_is_valid_and_the_same_every_time(case: str) -> None:
    assert json_files(CASES[case], "double", LOOP, ORIGIN) == json_files(
        CASES[case], "double", LOOP, ORIGIN
    )
    states = content(case, "double")["program"]["states"]
    assert set(states) == set(controller_program(CASES[case]).states)
    assert [name for name, state in states.items() if state["set_by_caller"]] == (
        ["coulomb", "constant"] if case == "scheduled" else []
    )


@pytest.mark.parametrize("number", NUMBERS)
def test_matlab_file_is_read_back_by_scipy(number: Number) -> None:
    ((name, data),) = matlab_files(CONTROLLER, number, LOOP, ORIGIN).items()
    assert name == "speed.mat"
    assert data == matlab_files(CONTROLLER, number, LOOP, ORIGIN)[name]
    found, hold, space = (
        scipy.io.loadmat(io.BytesIO(data), simplify_cells=True),
        coefficient_rounder(number),
        CONTROLLER.linear.discrete,
    )
    raw = scipy.io.loadmat(io.BytesIO(data))
    for key, rows in (
        ("a", space.a),
        ("b", space.b),
        ("c", space.c),
        ("d", space.d),
        ("sos", CONTROLLER.linear.sos),
    ):
        np.testing.assert_array_equal(
            raw[key], np.array([[hold(value) for value in row] for row in rows])
        )
    assert raw["l"].shape == (2, 1)
    assert found["Ts"] == 1e-3
    assert found["names"]["input"] == "integral(speed reference) - position"
    assert found["names"]["output"] == "current"
    assert found["prefilter"] == {"natural_frequency_rad_s": 30.0, "damping": 0.8}
    assert (found["law"]["kind"], found["law"]["gain"], found["law"]["action"]) == (
        "square_root",
        160.0,
        "brake",
    )
    assert found["notes"]["sha256"] == ORIGIN.sha256
    assert scipy.io.whosmat(io.BytesIO(data))[0] == ("a", (2, 2), "double")


def test_matlab_file_of_a_position_loop_has_its_blocks_and_of_order_0_its_shapes() -> None:
    ((_, data),) = matlab_files(CASES["position"], "double", LOOP, ORIGIN).items()
    found = scipy.io.loadmat(io.BytesIO(data), simplify_cells=True)
    assert found["limiter"]["condition"] == "energy"
    assert found["compensation"]["coulomb"] == 0.05
    assert "law" not in found

"""`NAME_unwrap` of the exported C: a wrapping encoder gives the positions without wraps."""

from __future__ import annotations

import ctypes
import functools
import math
import shutil
import subprocess
import zipfile
from io import BytesIO
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from frictool.adapters.controller_composition import controller_program
from frictool.control.fixed_point import fixed_program
from frictool.documents.bench import Encoder
from frictool.documents.controller import Controller, ProgramNumber
from frictool.documents.quantity import Quantity, Span
from frictool.documents.writing import to_yaml
from frictool.export import export
from frictool.export.encoder_wrap import encoder_wrap
from studies.command_line import run
from studies.rigs.example_controllers import CUT_LAW, clutch_controller
from studies.rigs.verified_controller import truthful
from tests.support.compiled_c import (
    COMPILERS,
    KINDS,
    NUMBERS,
    STRICT,
    built,
    library,
    needs_compiler,
    ran,
    write,
)

replace = msgspec.structs.replace
TURN = Quantity(2.0 * math.pi, unit="rad")
# a step that every format represents exactly, 2^-6 rad, and periods of 512 and 256 counts
EXACT = {
    "wrap": Encoder(step=Quantity(2.0**-6, unit="rad"), wrap=Quantity(8.0, unit="rad")),
    "wrap_bits": Encoder(step=Quantity(2.0**-6, unit="rad"), wrap_bits=8),
}
ROUNDED = {
    "turn": Encoder(counts_per_revolution=1000.0, wrap=TURN),
    "no whole counts": Encoder(step=Quantity(0.0123, unit="rad"), wrap=TURN),
}


def shared_out(kinds: dict[str, Encoder]) -> list[Any]:
    """Each kind in each number format, of which `make test` takes every format of one kind."""
    return [
        pytest.param(kind, number, marks=() if (k + n) % 2 == 0 else pytest.mark.accept)
        for k, kind in enumerate(kinds)
        for n, number in enumerate(NUMBERS)
    ]


DRIVER = """
#include "speed.h"
void follow(long n, const {reading} *readings, {kind} *positions);
void follow(long n, const {reading} *readings, {kind} *positions)
{{
    speed_encoder encoder;
    long k;

    speed_encoder_init(&encoder);
    for (k = 0; k < n; k++) {{
        positions[k] = speed_unwrap(&encoder, readings[k]);
    }}
}}
"""
INVALID = -(2**31)  # word of an invalid input
Values = np.ndarray[Any, np.dtype[Any]]


def wrapping(
    encoder: Encoder, travel: tuple[float, float] | None = (-60.0, 60.0), top: float = 400.0
) -> Controller:
    """The clutch's controller on a bench with this encoder."""
    base = clutch_controller(CUT_LAW)
    mechanics = replace(
        base.bench.mechanics,
        travel=None if travel is None else Span(*travel, unit="rad"),
        top_speed=Quantity(top, unit="rad/s"),
    )
    return replace(base, bench=replace(base.bench, encoder=encoder, mechanics=mechanics))


def follow(controller: Controller, number: ProgramNumber, folder: Path, shown: Values) -> Values:
    """Positions of the compiled `speed_unwrap` at readings in counts; NaN is an invalid reading."""
    write(controller, folder, number)
    fixed = number == "q31"
    kind = {"double": "double", "float": "float"}.get(number, "int32_t")
    (folder / "follow.c").write_text(DRIVER.format(kind=kind, reading="int64_t" if fixed else kind))
    path = folder / "follow.so"
    files = [str(folder / "speed.c"), str(folder / "follow.c")]
    command = [COMPILERS[0], *STRICT, "-O2", "-shared", "-fPIC", *files, "-o", str(path), "-lm"]
    subprocess.run(command, check=True)
    if fixed:
        readings: Values = np.where(np.isnan(shown), INVALID, np.nan_to_num(shown)).astype(np.int64)
    else:
        readings = (shown * controller.bench.encoder.resolution).astype(KINDS[number])
    positions = np.empty(len(shown), dtype=KINDS[number])
    ctypes.CDLL(str(path)).follow(
        ctypes.c_long(len(shown)),
        ctypes.c_void_p(readings.ctypes.data),
        ctypes.c_void_p(positions.ctypes.data),
    )
    return positions


@functools.cache
def counts(period: float) -> Values:
    """Counts of a motion over some periods in both directions, up to 0.49 period per sample."""
    rng = np.random.default_rng(2026)
    speeds = np.concatenate(
        [np.full(40, 0.11), np.full(60, -0.13), 0.48 * rng.uniform(-1.0, 1.0, 300), [0.49] * 6]
    )
    true: Values = np.floor(period * (0.95 + np.cumsum(speeds) - speeds[0])).astype(np.int64)
    return true


def shown(encoder: Encoder, true: Values) -> Values:
    """Counts that a wrapping encoder shows; a counter is signed, another sensor starts at 0."""
    assert encoder.period is not None
    period = encoder.period / encoder.resolution
    start = -period / 2.0 if encoder.wrap_bits else 0.0
    seen: Values = np.floor(start + (true - start) % period)
    return seen


def scale(controller: Controller, number: ProgramNumber) -> float:
    """Return the exported number of a position of 1 rad."""
    if number != "q31":
        return 1.0
    scaled = fixed_program(controller_program(controller))
    return 2.0 ** scaled.fractions[scaled.program.inputs["position"].index]


@needs_compiler
@pytest.mark.parametrize(("kind", "number"), shared_out(EXACT))
def test_wrapping_readings_give_the_drives_of_the_position_without_wraps(
    kind: str, number: ProgramNumber, tmp_path: Path
) -> None:
    encoder = EXACT[kind]
    controller = wrapping(encoder)
    assert encoder.period is not None
    true = counts(encoder.period / encoder.resolution)
    seen = shown(encoder, true)
    first = seen[0] - true[0]  # the first position is the reading, here within the travel
    assert np.ptp(true) > 2.0 * np.ptp(seen)
    found = follow(controller, number, tmp_path, seen)
    factor = encoder.resolution * scale(controller, number)
    wanted = ((true + first) * factor).astype(KINDS[number])
    assert found.tobytes() == wanted.tobytes()
    reference = np.full(len(found), wanted[-1])
    play = library(controller, number, tmp_path, COMPILERS[0], "-O2")
    drives = [
        play(np.column_stack([reference, position]))
        for position in (found, wanted, (seen * factor).astype(KINDS[number]))
    ]
    assert drives[0].tobytes() == drives[1].tobytes()
    assert drives[0].tobytes() != drives[2].tobytes()


@needs_compiler
@pytest.mark.parametrize(("kind", "number"), shared_out(EXACT))
def test_counts_that_decrease_forward_wrap_the_other_way(
    kind: str, number: ProgramNumber, tmp_path: Path
) -> None:
    encoder = EXACT[kind]
    assert encoder.period is not None
    controller = wrapping(replace(encoder, direction=-1))
    true = -counts(encoder.period / encoder.resolution)  # unbounded counts of the encoder
    seen = shown(encoder, true)
    # `follow` multiplies the readings by the resolution, but passes counts in q31
    found = follow(controller, number, tmp_path, seen if number == "q31" else -seen)
    factor = -encoder.resolution * scale(controller, number)
    wanted = ((true + seen[0] - true[0]) * factor).astype(KINDS[number])
    assert np.ptp(true) > 2.0 * np.ptp(seen)
    np.testing.assert_array_equal(found, wanted)
    (tmp_path / "follow.c").unlink()
    assert ran(built(tmp_path, COMPILERS[0], "-O1"))[0] == 0


@needs_compiler
@pytest.mark.parametrize(("kind", "number"), shared_out(ROUNDED))
def test_rounding_does_not_add_up_over_the_periods(
    kind: str, number: ProgramNumber, tmp_path: Path
) -> None:
    encoder = ROUNDED[kind]
    controller = wrapping(encoder)
    period = 2.0 * math.pi
    # a motion of eight turns forward and sixteen back, in rad, which the sensor rounds to counts
    true = np.concatenate([np.arange(0.3, 50.0, 0.7), np.arange(50.0, -50.0, -1.1)])
    seen = np.floor(true % period / encoder.resolution)
    found = follow(controller, number, tmp_path, seen).astype(np.float64)
    found /= scale(controller, number)
    precision = {"double": 1e-13, "float": 1e-5, "q31": 1e-6}[number]
    wanted = seen * encoder.resolution + period * np.floor(true / period)
    assert np.max(np.abs(found - wanted)) < precision
    assert np.max(np.abs(found - true)) < 1.01 * encoder.resolution


FIRST_POSITIONS: list[tuple[tuple[float, float] | None, int, int]] = [
    ((-3.0, 3.0), 350, -10),
    ((-3.0, 3.0), 10, 10),
    ((0.0, 6.0), 350, 350),  # beyond the travel, but nearer to it than -10 deg
    ((-1.0, 5.2), 350, -10),
    ((4.0, 10.0), 10, 370),
    ((-60.0, 60.0), 350, 350),
    (None, 350, 350),
]


@needs_compiler
@pytest.mark.parametrize(
    ("travel", "degrees", "position", "number"),
    [
        pytest.param(*case, number, marks=() if n == k % 3 else pytest.mark.accept)
        for k, case in enumerate(FIRST_POSITIONS)
        for n, number in enumerate(NUMBERS)
        if number != "q31" or case[0] is not None  # fixed point needs a travel
    ],
)
def test_first_position_is_within_the_travel(
    travel: tuple[float, float] | None,
    degrees: int,
    position: int,
    number: ProgramNumber,
    tmp_path: Path,
) -> None:
    controller = wrapping(Encoder(counts_per_revolution=360.0, wrap=TURN), travel)
    steps = np.array([math.nan, 0.0, math.nan, -1.0, 1.0])
    found = follow(controller, number, tmp_path, degrees + steps).astype(np.float64)
    if number == "q31":
        assert list(found[[0, 2]]) == [INVALID, INVALID]
        scaled = fixed_program(controller_program(controller))
        found *= 2.0 ** -scaled.fractions[scaled.program.inputs["position"].index]
    else:
        assert np.all(np.isnan(found[[0, 2]]))
    wanted = np.radians(position + steps[[1, 3, 4]])
    np.testing.assert_allclose(found[[1, 3, 4]], wanted, atol=1e-5)


@needs_compiler
@pytest.mark.parametrize(
    "number", ["double", pytest.param("float", marks=pytest.mark.accept), "q31"]
)
def test_self_test_notices_a_wrong_unwrapping(number: ProgramNumber, tmp_path: Path) -> None:
    controller = wrapping(ROUNDED["turn"], (-3.0, 3.0))
    write(controller, tmp_path / "c", number)
    assert ran(built(tmp_path / "c", COMPILERS[0], "-O2"))[0] == 0
    source = tmp_path / "c/speed.c"
    text = source.read_text()
    forward = "(encoder->reading - reading >"
    assert text.count(forward) == 1
    source.write_text(text.replace(forward, "(encoder->reading - reading > 3 * "))
    code, printed, _ = ran(built(tmp_path / "c", COMPILERS[0], "-O2"))
    assert (code, printed[:15]) == (1, "speed: reading ")


@needs_compiler
@pytest.mark.parametrize("number", ["double", "q31"])
def test_checkers_find_nothing(number: ProgramNumber, tmp_path: Path) -> None:
    write(wrapping(ROUNDED["turn"], (-3.0, 3.0)), tmp_path, number)
    sanitized = ("-O1", "-fsanitize=undefined,address", "-fno-sanitize-recover=all")
    assert ran(built(tmp_path, COMPILERS[0], *sanitized))[::2] == (0, "")
    if shutil.which("cppcheck") is not None:
        checks = ["--enable=all", "--inconclusive", "--suppress=missingIncludeSystem"]
        command = ["cppcheck", *checks, "--std=c99", "--quiet", "--error-exitcode=1"]
        files = [str(tmp_path / "speed.c"), str(tmp_path / "speed_selftest.c")]
        done = subprocess.run([*command, *files], capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize(
    ("top", "expected"),
    [
        (700.0, ""),
        (790.0, "during 3 invalid readings"),  # pi/(4 ms) = 785 rad/s
        (3200.0, "per sample"),  # pi/(1 ms) = 3142 rad/s
    ],
)
def test_speed_that_miscounts_wraps_is_a_warning(top: float, expected: str, tmp_path: Path) -> None:
    controller = truthful(wrapping(Encoder(counts_per_revolution=56.0, wrap=TURN), top=top))
    path = tmp_path / "controller.yaml"
    path.write_text(to_yaml(controller))
    result = run("export", path, "-o", tmp_path / "c")
    assert result.code == 0
    assert "speed_unwrap in speed.h removes the wraps" in result.stdout
    header = (tmp_path / "c/speed.h").read_text()
    assert "below 3142 rad/s, half a period a sample" in header
    assert "from 0.1 to 0.9 period, the axis moves 0.8 period forward" in header
    wrap = encoder_wrap(controller)
    assert wrap is not None
    if expected:
        assert f"half a period of the encoder {expected}" in result.stderr
        assert wrap.warning in header
    else:
        assert result.stderr == ""


def test_every_language_states_that_the_position_must_not_wrap() -> None:
    plain = clutch_controller(CUT_LAW)
    encoder = replace(plain.bench.encoder, wrap=TURN)
    controllers = [
        truthful(plain),
        truthful(replace(plain, bench=replace(plain.bench, encoder=encoder))),
    ]
    for language in ("c", "json", "cmsis", "matlab", "fmu"):
        for one, stated in zip(controllers, (False, True), strict=True):
            result = export(one, language)
            content = next(iter(result.files.values()))
            if language == "fmu":
                assert isinstance(content, bytes)
                content = zipfile.ZipFile(BytesIO(content)).read("modelDescription.xml")
            raw = content.encode() if isinstance(content, str) else content.replace(b"\0", b"")
            assert (b"without wraps" in raw) == stated, language
            assert ("without wraps" in "\n".join(result.lines())) == stated

"""Counts that decrease during forward motion: the exported constants carry the sign."""

from __future__ import annotations

import ctypes
import functools
import math
import subprocess
import zipfile
from io import BytesIO
from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.adapters.controller_composition import controller_program
from frictool.control.fixed_point import fixed_program
from frictool.documents.bench import Column, Encoder
from frictool.documents.controller import Controller, ProgramNumber
from frictool.documents.quantity import Quantity
from frictool.export import export
from frictool.export.encoder_reading import reading_notes
from frictool.export.golden_vectors import GoldenVectors, golden_vectors
from studies.rigs.example_controllers import CUT_LAW, clutch_controller
from studies.rigs.verified_controller import truthful
from tests.support.compiled_c import (
    COMPILERS,
    NUMBERS,
    STRICT,
    needs_compiler,
    sources,
    write,
)

replace = msgspec.structs.replace
TURN = Quantity(2.0 * math.pi, unit="rad")
COUNT = Column("encoder", "count")
FORWARD = Encoder(counts_per_revolution=56.0)
REVERSED = Encoder(counts_per_revolution=56.0, direction=-1)
# The clutch (N m, kg m^2) as in studies/target/loop.c, in a loop over raw counts or over the
# position. `sign`: change of the count per forward count.
LOOP = """
#include <math.h>
#include <stdint.h>
#include "speed.h"
void play(long n, int sign, int raw, double step, double *angles);
void play(long n, int sign, int raw, double step, double *angles)
{{
    speed_state state;
    double angle = 0.0, speed = 0.0;
    long k, j;

    speed_init(&state, 0);
    for (k = 0; k < n; k++) {{
        const long forward = (long)floor(angle / step + 0.5);
        const int32_t counts = (int32_t)(sign * forward);
        const {kind} position = raw ? {from_counts} : {from_position};
        const double effort = 0.0134 * {drive};

        for (j = 0; j < 100; j++) {{
            const double before = speed;
            const double pushed = before > 0.0 || (before >= 0.0 && effort > 0.0) ? 0.099 : -0.099;

            if (!(before < 0.0) && !(before > 0.0) && fabs(effort) <= 0.099) {{
                continue;
            }}
            speed += 1e-5 / 1.32e-5 * (effort - 3.81e-4 * before - pushed);
            speed = before * speed < 0.0 ? 0.0 : speed;
            angle += 1e-5 * speed;
        }}
        angles[k] = angle;
    }}
}}
"""


def with_encoder(encoder: Encoder, column: Column = COUNT) -> Controller:
    """The clutch's controller on a bench with this encoder and this column of the position."""
    base = clutch_controller(CUT_LAW)
    bench = replace(base.bench, encoder=encoder, columns=base.bench.columns | {"position": column})
    return replace(base, bench=bench)


def played(controller: Controller, number: ProgramNumber, folder: Path, raw: bool) -> np.ndarray:
    """Angles of the clutch in a loop of the compiled code with a reference of 40 rad."""
    write(controller, folder, number)
    encoder = controller.bench.encoder
    kind = {"double": "double", "float": "float"}.get(number, "int32_t")
    step = f"({kind})step"
    from_counts, from_position = (
        f"({kind})counts * SPEED_POSITION_PER_COUNT",
        f"({kind})forward * {step}",
    )
    drive = f"(double)speed_step(&state, ({kind})40, position)"
    if number == "q31":
        scaled = fixed_program(controller_program(controller))
        assert scaled.program.output is not None
        fraction = scaled.fractions[scaled.program.inputs["position"].index]
        from_counts = "SPEED_POSITION_FROM_COUNTS(counts)"
        from_position = f"(int32_t)lround((double)forward * step * {2.0**fraction!r})"
        amperes = 2.0 ** -scaled.fractions[scaled.program.output.index]
        drive = f"(double)speed_step(&state, SPEED_REFERENCE(40.0), position) * {amperes!r}"
    text = LOOP.format(kind=kind, from_counts=from_counts, from_position=from_position, drive=drive)
    (folder / "loop.c").write_text(text)
    library = folder / f"loop{raw:d}.so"
    files = [str(folder / "speed.c"), str(folder / "loop.c")]
    command = [COMPILERS[0], *STRICT, "-O1", "-shared", "-fPIC", *files, "-o", str(library), "-lm"]
    subprocess.run(command, check=True)
    angles = np.empty(600)
    ctypes.CDLL(str(library)).play(
        ctypes.c_long(angles.size),
        ctypes.c_int(encoder.direction),
        ctypes.c_int(raw),
        ctypes.c_double(encoder.resolution),
        ctypes.c_void_p(angles.ctypes.data),
    )
    return angles


@functools.cache
def plain_vectors(number: ProgramNumber) -> GoldenVectors:
    plain = with_encoder(FORWARD)
    return golden_vectors(plain, controller_program(plain), number)


@functools.cache
def usual_header(number: ProgramNumber) -> str:
    """Return the header, which contains no vectors, for an encoder that counts forward."""
    return sources(with_encoder(FORWARD), number, plain_vectors(number))["speed.h"]


@needs_compiler
@pytest.mark.parametrize("number", NUMBERS)
def test_loop_over_raw_counts_is_the_loop_over_the_position(
    number: ProgramNumber, tmp_path: Path
) -> None:
    step = Quantity(0.125, unit="rad")  # every format represents its multiples exactly
    controller = with_encoder(Encoder(step=step, direction=-1))
    raw, position = (played(controller, number, tmp_path, one) for one in (True, False))
    assert raw.tobytes() == position.tobytes()
    assert abs(raw[-1] - 40.0) < CUT_LAW.band  # with a wrong sign, the axis runs away


@pytest.mark.parametrize(
    ("encoder", "column", "stated"),
    [
        (FORWARD, COUNT, []),
        (FORWARD, Column("angle", "deg", scale=2.0, offset=1.0), []),
        (REVERSED, COUNT, ["decrease during forward motion", "columns.position"]),
        (REVERSED, Column("angle", "deg"), ["in deg, not in counts", "check that"]),
        (
            FORWARD,
            Column("angle", "deg", scale=-1.0),
            ["in deg with a negative scale", "check that"],
        ),
        (FORWARD, Column("n", "count", -0.25, 7.0), ["counts = -0.25 x (number in the file) + 7"]),
        (replace(FORWARD, index_reset=True), COUNT, ["the position must be continuous"]),
    ],
)
def test_header_states_the_counts(encoder: Encoder, column: Column, stated: list[str]) -> None:
    one = with_encoder(encoder, column)
    for number in NUMBERS:
        header = sources(one, number, plain_vectors(number))["speed.h"]
        assert (header == usual_header(number)) == (not stated)
        assert all(text in header for text in stated)
        line = next(text for text in header.splitlines() if "define SPEED_POSITION_PER" in text)
        assert ("(-0.11" in line) == (encoder.direction == -1)


def test_every_language_states_the_counts() -> None:
    encoder = replace(REVERSED, index_reset=True, wrap=TURN)
    controller = truthful(with_encoder(encoder))
    notes = reading_notes(controller)
    assert list(notes) == ["counts", "index"]
    for language in ("c", "json", "cmsis", "matlab", "fmu"):
        result = export(controller, language)
        content = next(iter(result.files.values()))
        if language == "fmu":
            assert isinstance(content, bytes)
            content = zipfile.ZipFile(BytesIO(content)).read("modelDescription.xml")
        raw = content.encode() if isinstance(content, str) else content.replace(b"\0", b"")
        for note in notes.values():
            assert note.encode() in raw, language
            assert note in "\n".join(result.lines())

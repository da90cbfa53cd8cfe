"""Fixed-point part of the C header: interval of every value, and macros that convert values.

A value in fixed point is an integer (the word of the value) times 2^-fraction; fraction is the
number of fraction bits.
"""

from __future__ import annotations

import math

from frictool.control.fixed_point import FixedProgram
from frictool.control.program import ProgramNode
from frictool.export.c_names import CNames, NamedArray

MULTIPLIER_BITS = 31


def proof_lines(names: CNames, scaled: FixedProgram) -> list[str]:
    """Return a line for each value: name, fraction bits, range of its word, range in SI."""
    lines = []
    for node in names.program.nodes:
        if (
            node.op == "constant"
            or node.is_logical
            or not (names.uses[node.index] or node.op == "state")
        ):
            continue
        called = (
            names.text.get(node.index)
            or names.results.get(node.index)
            or f"value_{node.index} ({node.op})"
        )
        low, high = scaled.words[node.index]
        fraction = scaled.fractions[node.index]
        inside = f"{math.ldexp(low, -fraction):.6g} to {math.ldexp(high, -fraction):.6g}"
        lines.append(
            f"{called.removeprefix('state->'):<28} {fraction:>8} "
            f"{f'{low} to {high}':>24}   {inside}"
        )
    return lines


def field_note(table: NamedArray, scaled: FixedProgram) -> str:
    """Return resolution and range [SI] of each element of a state as text.

    If all elements have the same resolution and range, the text states them once.
    """
    notes = []
    for node in table.nodes.values():
        low, high = (
            math.ldexp(word, -scaled.fractions[node.index]) for word in scaled.words[node.index]
        )
        notes.append(f"2^{-scaled.fractions[node.index]}, {low:.4g} to {high:.4g}")
    return "; ".join(dict.fromkeys(notes)) if len(set(notes)) == 1 else "; ".join(notes)


def conversion_macros(
    prefix: str, scaled: FixedProgram, step: float, drive: ProgramNode
) -> list[str]:
    """Return lines of C macros that convert inputs and drive to and from fixed-point words.

    For every input and the drive, macros state the number of fraction bits, the lowest and the
    highest word. For every input, a macro also converts a constant in SI. Two more macros convert
    encoder counts to the position's word, and the drive's word to thousandths of an A or V.

    `prefix`: first part of each macro's name.
    `step`: position per encoder count [rad | m]; negative if the counts decrease forward.
    """
    lines: list[str] = []
    program = scaled.program
    for name, node in [*program.inputs.items(), ("drive", drive)]:
        upper, fraction, (low, high) = (
            f"{prefix}_{name.upper()}",
            scaled.fractions[node.index],
            scaled.words[node.index],
        )
        lines += [
            "",
            f"/* {name} = word 2^{-fraction}, {math.ldexp(low, -fraction):.6g} to "
            f"{math.ldexp(high, -fraction):.6g} */",
            f"#define {upper}_FRACTION {fraction}",
            f"#define {upper}_LOW ({low})",
            f"#define {upper}_HIGH ({high})",
        ]
        if name != "drive":
            scale = f"{math.ldexp(1.0, fraction)!r}"
            lines.append(
                f"#define {upper}(value) ((int32_t)((value) * {scale} + ((value) < 0 ? "
                "-0.5 : 0.5))) /* of a constant, at compile time */"
            )
    counts = _from_counts(step, scaled.fractions[program.inputs["position"].index])
    lines += [
        "",
        f"/* Word of the position from encoder counts of {step!r}. */",
        f"#define {prefix}_POSITION_FROM_COUNTS(counts) {counts}",
    ]
    fraction = scaled.fractions[drive.index]
    thousand = _rounded_quotient("(int64_t)(word) * 1000", "(word) < 0", fraction)
    lines += [
        "",
        "/* The drive in thousandths of its unit. */",
        f"#define {prefix}_DRIVE_IN_THOUSANDTHS(word) {thousand}",
    ]
    return lines


def multiplier(step: float, fraction: int) -> tuple[int, int]:
    """Return integers (m, n): encoder counts times m 2^-n give the position in fixed point.

    `step`: position per encoder count [rad | m]; negative if the counts decrease forward.
    `fraction`: number of fraction bits of the position.

    The magnitude of m has MULTIPLIER_BITS bits if n > 0; m has the sign of `step`.
    """
    n = max(MULTIPLIER_BITS - math.frexp(step)[1] - fraction, 0)
    return round(math.ldexp(step, fraction + n)), n


def _from_counts(step: float, fraction: int) -> str:
    m, n = multiplier(step, fraction)
    negative = "(counts) < 0" if m >= 0 else "(counts) > 0"
    return _rounded_quotient(f"(int64_t)(counts) * {m}", negative, n)


def _rounded_quotient(product: str, negative: str, n: int) -> str:
    """Return a C expression for `product` times 2^-n, rounded to nearest, halves away from zero.

    `negative`: C condition that the product is negative.
    """
    if n <= 0:
        return f"((int32_t)({product} * {2**-n}))"
    half = f"INT64_C({2 ** (n - 1)})"
    return f"((int32_t)(({product} + ({negative} ? -{half} : {half})) / INT64_C({2**n})))"

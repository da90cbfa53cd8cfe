"""A file with something changed: bits, bytes, blocks, lengths, cells and lines."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

LONGEST = 64  # bytes of a block
NUMBERS = (
    0,
    1,
    3,
    1_000_000,
    *(value for bits in (8, 16, 31, 32, 62, 63, 64) for value in (2**bits - 1, 2 ** (bits - 1))),
)
CELLS = (
    *(b"nan", b"inf", b"-1e999", b"1e-320", b"9" * 400, b"-"),
    *(b"", b'"', b'""', b"text", b"1,5", b"1.5.2", b"0x10", b"1_0", b"\xff\xfe", b"\0"),
)

TAGS = (
    *(
        b"!!float",
        b"!!int",
        b"!!str",
        b"!!bool",
        b"!!null",
        b"!!binary",
        b"!!timestamp",
        b"!!set",
        b"!!omap",
        b"!!pairs",
        b"!!seq",
    ),
    *(
        b"!!map",
        b"!!python/object:os.system",
        b"!!python/name:x",
        b"!own",
        b"!<tag:x,2000:y>",
        b"!",
        b"&a",
        b"*a",
        b"!!merge",
    ),
)

Mutation = Callable[[bytearray, np.random.Generator], None]


def _at(data: bytearray, rng: np.random.Generator) -> tuple[int, int]:
    """The bounds of a block."""
    start = int(rng.integers(len(data)))
    return start, min(len(data), start + int(rng.integers(1, LONGEST)))


def flip(data: bytearray, rng: np.random.Generator) -> None:
    data[int(rng.integers(len(data)))] ^= 1 << int(rng.integers(8))


def overwrite(data: bytearray, rng: np.random.Generator) -> None:
    start, end = _at(data, rng)
    data[start:end] = rng.bytes(end - start)


def delete(data: bytearray, rng: np.random.Generator) -> None:
    start, end = _at(data, rng)
    del data[start:end]


def double(data: bytearray, rng: np.random.Generator) -> None:
    start, end = _at(data, rng)
    data[start:start] = data[start:end]


def move(data: bytearray, rng: np.random.Generator) -> None:
    start, end = _at(data, rng)
    block = data[start:end]
    del data[start:end]
    to = int(rng.integers(len(data) + 1))
    data[to:to] = block


def cut(data: bytearray, rng: np.random.Generator) -> None:
    del data[int(rng.integers(len(data))) :]


def number(data: bytearray, rng: np.random.Generator) -> None:
    """A length, an offset or a count that is too large, too small or of the wrong sign."""
    size = int(rng.choice([1, 2, 4, 8]))
    value = NUMBERS[int(rng.integers(len(NUMBERS)))] % 2 ** (8 * size)
    start = int(rng.integers(len(data)))
    data[start : start + size] = value.to_bytes(size, "little" if rng.integers(4) else "big")


def cell(data: bytearray, rng: np.random.Generator) -> None:
    """Another text between two delimiters, where the file has any."""
    start = int(rng.integers(len(data)))
    marks = [place for mark in b",;\t\n" if (place := data.find(mark, start)) >= 0]
    begin = min(marks, default=start) + 1
    ends = [place for mark in b",;\t\n" if (place := data.find(mark, begin)) >= 0]
    data[begin : min(ends, default=begin)] = CELLS[int(rng.integers(len(CELLS)))]


def lines(data: bytearray, rng: np.random.Generator) -> None:
    """Two lines change places, or one is there twice, or is missing."""
    parts = data.split(b"\n")
    one, other = (int(place) for place in rng.integers(len(parts), size=2))
    action = int(rng.integers(3))
    if action == 0:
        parts[one], parts[other] = parts[other], parts[one]
    elif action == 1:
        parts.insert(other, parts[one])
    else:
        del parts[one]
    data[:] = b"\n".join(parts)


def tag(data: bytearray, rng: np.random.Generator) -> None:
    """An explicit tag of YAML before a value, where the file has any."""
    start = int(rng.integers(len(data)))
    place = data.find(b": ", start)
    if place >= 0:
        data[place + 2 : place + 2] = TAGS[int(rng.integers(len(TAGS)))] + b" "


MUTATIONS: tuple[Mutation, ...] = (
    flip,
    flip,
    overwrite,
    delete,
    double,
    move,
    cut,
    number,
    number,
    cell,
    lines,
    tag,
)


def mutated(data: bytes, rng: np.random.Generator) -> bytes:
    """The file after one to four mutations."""
    out = bytearray(data)
    for _ in range(int(rng.integers(1, 5))):
        if out:
            MUTATIONS[int(rng.integers(len(MUTATIONS)))](out, rng)
    return bytes(out)

"""Decoder of JSON messages, with or without a schema."""

from __future__ import annotations

import msgspec

from frictool.logs.recordings.object_decoder import ObjectDecoder

LONGEST = 2_000_000  # bytes, maximum size of a message


def decoded(data: bytes) -> object:
    """Return the value of a JSON text; raise ValueError if `data` is too long or not JSON."""
    if len(data) > LONGEST:
        raise ValueError(f"is {len(data)} bytes of JSON; allowed: at most {LONGEST}")
    try:
        value: object = msgspec.json.decode(data)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"is not JSON ({error})") from None
    return value


class JsonDecoder(ObjectDecoder):
    """Decoder of JSON messages; `true` is 1, `false` is 0, and `null` is a missing number."""

    def __init__(self) -> None:
        super().__init__(decoded)

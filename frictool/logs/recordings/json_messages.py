"""Messages in JSON, with or without a schema: the numbers stand in them by name."""

from __future__ import annotations

import msgspec

from frictool.logs.recordings.object_decoder import ObjectDecoder

LONGEST = 2_000_000  # bytes of a message


def _decoded(data: bytes) -> object:
    if len(data) > LONGEST:
        raise ValueError(f"is {len(data)} bytes of JSON; allowed: {LONGEST}")
    try:
        found: object = msgspec.json.decode(data)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"is no JSON ({error})") from None
    return found


class JsonDecoder(ObjectDecoder):
    """Numbers of JSON messages; true is 1, false 0, null nothing."""

    def __init__(self) -> None:
        super().__init__(_decoded)

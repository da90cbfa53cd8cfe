"""Detection of the encoding of text files, and conversion to an encoding that contains ASCII."""

from __future__ import annotations

import codecs
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from frictool.errors import LogError

READ_BYTES = 1 << 20
MARKS = {
    codecs.BOM_UTF8: "utf-8",
    codecs.BOM_UTF16_LE: "utf-16-le",
    codecs.BOM_UTF16_BE: "utf-16-be",
}


@dataclass(frozen=True)
class TextEncoding:
    """Encoding of a text file.

    name: name of the encoding in Python.
    mark: length of the byte-order mark before the text, in bytes.
    """

    name: str
    mark: int

    @property
    def is_wide(self) -> bool:
        """Return True for UTF-16, in either byte order."""
        return self.name.startswith("utf-16")

    @property
    def shown(self) -> str:
        """Return the name of the encoding for messages."""
        return {"utf-8": "UTF-8", "latin-1": "Latin-1"}.get(self.name, "UTF-16")


def encoding_of(head: bytes, requested: str | None = None) -> TextEncoding:
    """Return the encoding of a text that begins with the bytes `head`.

    A byte-order mark determines the encoding. If the text has no such mark, the encoding is
    `requested`. If `requested` is None, a text with NUL bytes is UTF-16; any other text is UTF-8 if
    it is valid UTF-8, else Latin-1.
    """
    for mark, name in MARKS.items():
        if head.startswith(mark):
            return TextEncoding(name, len(mark))
    if requested == "utf-16" or (requested is None and _looks_wide(head)):
        return TextEncoding("utf-16-be" if head[:1] == b"\0" else "utf-16-le", 0)
    if requested is not None:
        return TextEncoding(requested, 0)
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)
    except UnicodeDecodeError:
        return TextEncoding("latin-1", 0)
    return TextEncoding("utf-8", 0)


def is_text(head: bytes) -> bool:
    """Return True if the bytes may be the beginning of a text.

    Bytes with NUL are a text only in UTF-16, which is recognised by its byte-order mark, or by NUL
    in nearly every second byte.
    """
    return b"\0" not in head or encoding_of(head).is_wide


def _looks_wide(head: bytes) -> bool:
    pairs = len(head) // 2
    fewer, more = sorted((head[: 2 * pairs : 2].count(0), head[1 : 2 * pairs : 2].count(0)))
    return pairs > 1 and more > 0.9 * pairs and fewer < 0.1 * pairs


def text_bytes(path: Path, encoding: TextEncoding) -> Iterator[tuple[bytes, int]]:
    """Yield (piece of the text, number of bytes of the file read so far).

    UTF-16 is converted to UTF-8; text in other encodings is unchanged. Raises LogError if the file
    cannot be read.
    """
    plain = _Transcoder(encoding)
    try:
        with path.open("rb") as stream:
            done = len(stream.read(encoding.mark))
            while data := stream.read(READ_BYTES):
                done += len(data)
                yield plain.bytes(data), done
    except OSError as error:
        raise LogError(path, f"cannot be read: {error.strerror or error}") from None


def head_bytes(head: bytes, encoding: TextEncoding) -> bytes:
    """Return the first bytes of a file, converted in the same way as by `text_bytes`."""
    return _Transcoder(encoding).bytes(head[encoding.mark :])


class _Transcoder:
    """Converter of a text's bytes, piece by piece, to an encoding that contains ASCII."""

    def __init__(self, encoding: TextEncoding) -> None:
        self._decoder = (
            codecs.getincrementaldecoder(encoding.name)(errors="replace")
            if encoding.is_wide
            else None
        )

    def bytes(self, piece: bytes) -> bytes:
        return (
            piece
            if self._decoder is None
            else self._decoder.decode(piece).encode("utf-8", "replace")
        )


def decoded(data: bytes, encoding: TextEncoding) -> str:
    """Return a part of the text as str; invalid bytes become the replacement character."""
    return data.decode("latin-1" if encoding.name == "latin-1" else "utf-8", "replace")

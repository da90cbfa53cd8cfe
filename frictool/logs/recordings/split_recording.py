"""Reading of the parts of one split recording, in order, as one file."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from frictool.errors import LogError
from frictool.logs.recordings.recording import MessageGap, RecordingFile, Topic
from frictool.logs.recordings.serialised_messages import Messages


class SplitRecording:
    """Recording that is split into several files (implements RecordingFile).

    A part need not contain all topics of the recording.
    """

    def __init__(self, path: Path, parts: list[RecordingFile]) -> None:
        self.source = str(path)
        self._parts = parts
        self.size = sum(part.size for part in parts)
        self.topics: dict[str, Topic] = {}
        for part in parts:
            for name, topic in part.topics.items():
                known = self.topics.setdefault(name, topic)
                if known.kind != topic.kind:
                    raise LogError(
                        part.source,
                        f"topic {name} has type {topic.kind}, but {known.kind} in another part; "
                        "give parts of one recording",
                    )
                if not known.paths:
                    self.topics[name] = topic

    def messages(self, topic: str) -> Iterator[tuple[Messages | MessageGap, int]]:
        """Yield the messages of all parts in order (see RecordingFile)."""
        before = 0
        for part in self._parts:
            for piece, done in part.messages(topic) if topic in part.topics else ():
                named = (
                    MessageGap(f"{Path(part.source).name} {piece.reason}", piece.samples)
                    if isinstance(piece, MessageGap)
                    else piece
                )
                yield named, before + done
            before += part.size
